! SPDX-License-Identifier: BSD-3-Clause
!> How large forces, gaps and motions of a problem are at a point, by its data alone: not by its answers, which may be rounding as a
!> whole. Terms are added without sign, because they may cancel.
module sig_problem_sizes
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  implicit none(type, external)
  private
  public :: problem_sizes_t, sizes_at

  type :: problem_sizes_t
    !> [force] largest load on a dof, those of imposed strains included
    real(rk) :: force = 0
    !> [length] largest gap
    real(rk) :: gap = 0
    !> [length] largest prescribed displacement
    real(rk) :: motion = 0
  end type problem_sizes_t

contains

  !> Returns the sizes at a point. Local.
  pure function sizes_at(system, theta) result(sizes)
    type(contact_system_t), intent(in) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    type(problem_sizes_t) :: sizes
    type(load_pattern_t) :: pattern

    call system%boundary%get_forces(pattern)
    sizes%force = maxval(pattern%part_sizes(theta, system%map%n_dofs))
    sizes%gap = max(0.0_rk, maxval(matmul(abs(system%rows%gap), abs(theta))))
    associate (values => system%boundary%prescribed_values)
      sizes%motion = max(0.0_rk, maxval(matmul(abs(values), abs(theta(:size(values, 2))))))
    end associate
  end function sizes_at
end module sig_problem_sizes
