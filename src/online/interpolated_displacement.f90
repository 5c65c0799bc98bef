! SPDX-License-Identifier: BSD-3-Clause
!> Displacements of an interpolated model: interpolated at the exact dofs, by modes at the others, or none.
module sig_interpolated_displacement
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_interpolated_data, only: interpolated_data_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_shape_checks, only: place_in_ascending
  implicit none(type, external)
  private
  public :: close_by_modes, fill_interpolated_displacement, interpolated_displacement_of_dof, n_modes_of, solve_modes

contains

  !> Returns the number of modes of all bodies together.
  pure integer function n_modes_of(data) result(n_modes)
    class(interpolated_data_t), intent(in) :: data
    integer :: i

    n_modes = 0
    if (.not. allocated(data%modes)) return
    n_modes = sum([(data%modes(i)%n_modes(), i=1, size(data%modes))])
  end function n_modes_of

  !> Computes the coordinates of the modes of all bodies under loads and contact forces, a bound of the residual of equilibrium, and
  !> the size of the displacement. The coordinates of a body are zero if its reduced stiffness is not positive definite. Requires: a
  !> model with modes (has_modes).
  subroutine solve_modes(data, theta, unknowns, coordinates, residual, field_size)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z: contact forces, shape (n_multipliers); values on anchors do not count
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [length] coordinates, one body after the other, shape (n_modes_of)
    real(rk), contiguous, intent(inout) :: coordinates(:)
    !> [sqrt(force*length)] upper bound of |u_r - u(z)|_K, and |u_r|_K, where u_r is the displacement by modes and u(z) the exact
    !> one under the same forces
    real(rk), intent(out) :: residual
    real(rk), intent(out) :: field_size
    real(rk) :: forces(size(unknowns)), own_energy, own_residual
    integer :: first, i, last

    forces = unknowns
    forces(data%anchors) = 0
    residual = 0
    field_size = 0
    last = 0
    do i = 1, size(data%modes)
      first = last + 1
      last = last + data%modes(i)%n_modes()
      call data%modes(i)%solve(theta, forces, coordinates(first:last), own_residual, own_energy)
      residual = residual + own_residual**2
      field_size = field_size + own_energy
    end do
    residual = sqrt(residual)
    field_size = sqrt(field_size)
  end subroutine solve_modes

  !> Computes B u_r, by which all contacts close, and a factor b with K <= b K(mu_0) for all bodies. u_r is the displacement by
  !> modes; the rigid motions of bodies that only contact holds are left out. K(mu_0) is the stiffness for the moduli for which the
  !> modes were made. Requires: a model with modes (has_modes).
  subroutine close_by_modes(data, theta, coordinates, closing, stiffest)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] coordinates from solve_modes
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: closing(:)
    !> [-] b
    real(rk), intent(out) :: stiffest
    integer :: first, i, last

    closing = 0
    stiffest = 0
    last = 0
    do i = 1, size(data%modes)
      first = last + 1
      last = last + data%modes(i)%n_modes()
      call data%modes(i)%add_closing(theta, coordinates(first:last), closing)
      stiffest = max(stiffest, data%modes(i)%stiffest(theta))
    end do
  end subroutine close_by_modes

  !> Computes the displacement of all dofs; it is NaN for dofs of which the model has none.
  subroutine fill_interpolated_displacement(data, theta, unknowns, coordinates, displacement)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z (unknowns of answer_t), shape (n_multipliers)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [length] coordinates from solve_modes
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> [length] shape (n_dofs)
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: exact(size(data%exact_dofs))
    integer :: first, i, last

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    last = 0
    do i = 1, size(data%modes)
      first = last + 1
      last = last + data%modes(i)%n_modes()
      call data%modes(i)%add_field(theta, coordinates(first:last), displacement)
    end do
    if (size(data%modes) > 0 .and. size(data%anchors) > 0) &
      call multiply(1.0_rk, data%mode_motions, data%moves(theta, unknowns), 1.0_rk, displacement)
    call data%field(theta, unknowns, exact)
    displacement(data%exact_dofs) = exact
  end subroutine fill_interpolated_displacement

  !> Returns the displacement [length] of one dof; NaN if the model has none of this dof.
  pure real(rk) function interpolated_displacement_of_dof(data, theta, unknowns, coordinates, dof) result(displacement)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] z (unknowns of answer_t), shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    !> [length] coordinates from solve_modes
    real(rk), intent(in) :: coordinates(:)
    !> 1-based
    integer, intent(in) :: dof
    integer :: first, i, last

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    i = place_in_ascending(data%exact_dofs, dof)
    if (i > 0) then
      displacement = data%displacement_of(theta, unknowns, i)
    else if (size(data%modes) > 0) then
      displacement = dot_product(data%mode_motions(dof, :), data%moves(theta, unknowns))
      last = 0
      do i = 1, size(data%modes)
        first = last + 1
        last = last + data%modes(i)%n_modes()
        displacement = displacement + data%modes(i)%displacement_of(theta, coordinates(first:last), dof)
      end do
    end if
  end function interpolated_displacement_of_dof
end module sig_interpolated_displacement
