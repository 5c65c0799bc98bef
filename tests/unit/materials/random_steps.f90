! SPDX-License-Identifier: BSD-3-Clause
!> Steps of all laws at random, for tests of what every law promises.
module random_steps
  use sig_kinds, only: rk
  use sig_material_law, only: creep_strain_at, creep_strains, material_law_t, n_shared_state, plastic_strain_at, plastic_strains
  use sig_material_laws, only: make_law
  use sig_random_numbers, only: random_t
  implicit none(type, external)
  private
  public :: step_t, n_cases, random_step, rotation, rotated_strain, rotated_stress

  !> kinds of cases that random_step knows
  integer, parameter :: n_cases = 6

  !> One step of a law, from a state with plastic strain and creep strain.
  type :: step_t
    class(material_law_t), allocatable :: law
    real(rk), allocatable :: properties(:)
    real(rk) :: strain(6) = 0, dt = 0, state(n_shared_state) = 0
  end type step_t

contains

  !> Returns a step: perfect, isotropic, kinematic, curve, creep, curve and creep. Some are elastic; most yield.
  subroutine random_step(random, i_case, step)
    type(random_t), intent(inout) :: random
    integer, intent(in) :: i_case
    type(step_t), intent(out) :: step
    real(rk), parameter :: curve(4) = [0.0_rk, 1.0e-3_rk, 4.0e-3_rk, 1.0e-2_rk]
    real(rk), parameter :: stresses(4) = [250.0_rk, 300.0_rk, 330.0_rk, 345.0_rk]
    real(rk), parameter :: elastic(2) = [200.0e3_rk, 0.3_rk]
    real(rk) :: share

    call random%fraction(share)
    select case (i_case)
    case (1)
      call make_law('plasticity', [0.0_rk], step%law)
      step%properties = [elastic, 0.0_rk, 0.0_rk, 250.0_rk]
    case (2)
      call make_law('plasticity', [0.0_rk], step%law)
      step%properties = [elastic, 0.0_rk, 20.0e3_rk * share, 250.0_rk]
    case (3)
      call make_law('plasticity', [0.0_rk], step%law)
      step%properties = [elastic, 20.0e3_rk * share, 3.0e3_rk, 250.0_rk]
    case (4)
      call make_law('plasticity', curve, step%law)
      step%properties = [elastic, 0.0_rk, 0.0_rk, stresses]
    case (5)
      call make_law('norton_creep', curve, step%law)
      ! a rate of 1e-3 at 300 MPa
      step%properties = [elastic, 1.0e-3_rk * 300.0_rk**(-1 - 6 * share), 1 + 6 * share]
    case default
      call make_law('plasticity_with_creep', curve, step%law)
      step%properties = [elastic, 1.0e-15_rk, 5.0_rk, 500.0_rk, stresses]
    end select
    call random%fraction(step%dt)
    call fill(random, 6.0e-3_rk, step%strain)
    call fill_state(random, step%state)
    if (i_case == 5) step%state(plastic_strains) = 0
    if (i_case < 5) step%state(creep_strains) = 0
  end subroutine random_step

  !> Sets numbers between -size and size.
  subroutine fill(random, size, values)
    type(random_t), intent(inout) :: random
    real(rk), intent(in) :: size
    real(rk), intent(out) :: values(:)
    integer :: i

    do i = 1, ubound(values, 1)
      call random%fraction(values(i))
    end do
    values = size * (2 * values - 1)
  end subroutine fill

  !> Sets strains that keep the volume, and lengths of their paths.
  subroutine fill_state(random, state)
    type(random_t), intent(inout) :: random
    real(rk), intent(out) :: state(:)

    call fill(random, 1.0e-3_rk, state)
    state(plastic_strains(3)) = -sum(state(plastic_strains(:2)))
    state(creep_strains(3)) = -sum(state(creep_strains(:2)))
    call random%fraction(state(plastic_strain_at))
    state(plastic_strain_at) = 6.0e-3_rk * state(plastic_strain_at)
    call random%fraction(state(creep_strain_at))
  end subroutine fill_state

  !> Returns a rotation of space, from a quaternion.
  function rotation(random) result(matrix)
    type(random_t), intent(inout) :: random
    real(rk) :: matrix(3, 3), q(4)

    call fill(random, 1.0_rk, q)
    q = q / norm2(q)
    associate (a => q(1), b => q(2), c => q(3), d => q(4))
      matrix(1, :) = [1 - 2 * (c**2 + d**2), 2 * (b * c - a * d), 2 * (b * d + a * c)]
      matrix(2, :) = [2 * (b * c + a * d), 1 - 2 * (b**2 + d**2), 2 * (c * d - a * b)]
      matrix(3, :) = [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b**2 + c**2)]
    end associate
  end function rotation

  !> Returns a strain, whose shears are angles, after a rotation.
  pure function rotated_strain(matrix, strain) result(rotated)
    real(rk), intent(in) :: matrix(3, 3), strain(6)
    real(rk) :: rotated(6)

    rotated = rotated_stress(matrix, [strain(:3), strain(4:) / 2])
    rotated(4:) = 2 * rotated(4:)
  end function rotated_strain

  !> Returns a stress after a rotation.
  pure function rotated_stress(matrix, stress) result(rotated)
    real(rk), intent(in) :: matrix(3, 3), stress(6)
    real(rk) :: full(3, 3), rotated(6)

    full(1, :) = [stress(1), stress(4), stress(6)]
    full(2, :) = [stress(4), stress(2), stress(5)]
    full(3, :) = [stress(6), stress(5), stress(3)]
    full = matmul(matmul(matrix, full), transpose(matrix))
    rotated = [full(1, 1), full(2, 2), full(3, 3), full(1, 2), full(2, 3), full(1, 3)]
  end function rotated_stress
end module random_steps
