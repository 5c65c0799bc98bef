! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of the condensed problem whose elastic constants depend on the parameters.
module sig_interpolated_derivative
  use sig_body_derivative, only: body_derivative_t
  use sig_body_modes_derivative, only: differentiate_modes
  use sig_gradient, only: gradient_t
  use sig_interpolated_data, only: interpolated_data_t
  use sig_kinds, only: rk
  use sig_lcp_derivative, only: differentiate_lcp, lcp_derivative_t
  use sig_linear_algebra, only: multiply
  use sig_reduced_exact, only: round_work
  use sig_shape_checks, only: place_in_ascending
  implicit none(type, external)
  private
  public :: differentiate_interpolated, interpolated_displacement_changes, mode_displacement_change

contains

  !> Computes the derivatives of unknowns, multipliers, moves of the anchors (sig_interpolated_data), and coordinates of modes with
  !> respect to each parameter. If is_singular is true, there is no derivative and `gradient` does not change: the contact forces
  !> are not unique, the loads move a body that no contact force holds (is_pushed), or the problem of the contacts that graze has no
  !> solution (differentiate_lcp).
  subroutine differentiate_interpolated(data, theta, unknowns, coordinates, forces, gradient, is_singular, is_pushed)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z of sig_interpolated_data, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [length] coordinates of the modes, one body after the other
    real(rk), intent(in) :: coordinates(:)
    !> [force] contact forces, shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    !> in: direction, is_one_sided and theta; out: the other derivatives and n_grazing; is_one_sided becomes true for more
    !> parameters where a contact that grazes makes it so
    type(gradient_t), intent(inout) :: gradient
    logical, intent(out) :: is_singular
    logical, intent(out) :: is_pushed
    real(rk), allocatable :: changes(:, :), compliance(:, :), opening(:), terms(:)
    type(lcp_derivative_t) :: derivative
    integer :: i

    associate (n => size(unknowns))
      allocate (compliance(n, n), opening(n), changes(n, size(gradient%theta, 2)))
    end associate
    call data%evaluate(theta, compliance, opening)
    do i = 1, size(changes, 2)
      call change_opening(data, theta, gradient%direction * gradient%theta(:, i), unknowns, changes(:, i))
    end do
    call round_work(data%anchors, data%scale * matmul(abs(data%anchor_forces), abs(gradient%theta)), changes)
    terms = gradient%sizes(data%opening_terms(theta), changes)
    call differentiate_lcp(compliance, opening, terms, unknowns, changes, derivative, data%anchors)
    is_singular = derivative%is_singular
    is_pushed = derivative%is_pushed
    if (is_singular) return
    call gradient%take_forces(derivative, data%anchors, data%scale)
    call gradient%find_loose(compliance, data%anchors, data%scale, terms, unknowns, forces)
    if (allocated(gradient%moves)) deallocate (gradient%moves)
    allocate (gradient%moves(size(data%anchors), size(changes, 2)))
    if (allocated(gradient%coordinates)) deallocate (gradient%coordinates)
    allocate (gradient%coordinates(size(coordinates), size(changes, 2)))
    do i = 1, size(changes, 2)
      gradient%moves(:, i) = move_changes(data, theta, gradient%theta(:, i), unknowns, gradient%unknowns(:, i))
      call change_modes(data, theta, gradient%theta(:, i), coordinates, gradient%unknowns(:, i), gradient%coordinates(:, i))
    end do
  end subroutine differentiate_interpolated

  !> Computes the changes of the mode coordinates of all bodies, one body after the other, for given changes of terms and unknowns.
  subroutine change_modes(data, theta, theta_change, coordinates, unknown_change, changes)
    class(interpolated_data_t), intent(in) :: data
    !> values of the terms and their changes, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [length] coordinates at the point, shape (n_modes)
    real(rk), intent(in) :: coordinates(:)
    !> [force] change of z, shape (n_multipliers); values on anchors do not count
    real(rk), intent(in) :: unknown_change(:)
    !> [length] shape (n_modes)
    real(rk), intent(out) :: changes(:)
    real(rk) :: force_change(size(unknown_change))
    integer :: first, i, last

    force_change = unknown_change
    force_change(data%anchors) = 0
    last = 0
    do i = 1, size(data%modes)
      first = last + 1
      last = last + data%modes(i)%n_modes()
      call differentiate_modes(data%modes(i), theta, theta_change, coordinates(first:last), force_change, changes(first:last))
    end do
  end subroutine change_modes

  !> Returns the derivative [length per unit of the parameter] of a dof's displacement by modes with respect to one parameter. The
  !> displacement is linear in the terms, the coordinates and the moves. Requires: a model with modes (has_modes).
  pure real(rk) function mode_displacement_change(data, gradient, i_parameter, dof) result(change)
    class(interpolated_data_t), intent(in) :: data
    !> result of differentiate_interpolated
    type(gradient_t), intent(in) :: gradient
    !> number of the parameter, 1-based
    integer, intent(in) :: i_parameter
    !> 1-based
    integer, intent(in) :: dof
    integer :: first, i, last

    change = dot_product(data%mode_motions(dof, :), gradient%moves(:, i_parameter))
    last = 0
    do i = 1, size(data%modes)
      first = last + 1
      last = last + data%modes(i)%n_modes()
      change = change + data%modes(i)%displacement_of(gradient%theta(:, i_parameter), &
        gradient%coordinates(first:last, i_parameter), dof)
    end do
  end function mode_displacement_change

  !> Computes the change, to first order, of W z + q (evaluate of sig_interpolated_data) for constant z and a given change of the
  !> terms.
  subroutine change_opening(data, theta, theta_change, unknowns, opening)
    class(interpolated_data_t), intent(in) :: data
    !> values of the terms and their changes, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [force] z, shape (n_multipliers); values on anchors do not count, because their columns of W do not change
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [length] the change, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    real(rk) :: forces(size(unknowns))
    type(body_derivative_t) :: derivative
    integer :: i

    forces = unknowns
    forces(data%anchors) = 0
    call multiply(1.0_rk, data%gap, theta_change, 0.0_rk, opening)
    do i = 1, size(data%bodies)
      call derivative%create(data%bodies(i), theta, theta_change)
      call derivative%add_opening(data%bodies(i), forces, opening)
    end do
    opening(data%anchors) = data%scale * matmul(data%anchor_forces, theta_change)
  end subroutine change_opening

  !> Returns the changes [length] of how far each anchor closes (moves in sig_interpolated_data).
  function move_changes(data, theta, theta_change, unknowns, unknown_change) result(changes)
    class(interpolated_data_t), intent(in) :: data
    !> values of the terms and their changes, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [force] z of sig_interpolated_data, with the openings of anchors, and its change; shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(in) :: unknown_change(:)
    real(rk) :: changes(size(data%anchors))
    real(rk) :: forces(size(unknowns)), force_change(size(unknowns))
    type(body_derivative_t) :: derivative
    integer :: i, i_body

    forces = unknowns
    forces(data%anchors) = 0
    force_change = unknown_change
    force_change(data%anchors) = 0
    do i = 1, size(changes)
      changes(i) = dot_product(data%gap(data%anchors(i), :), theta_change) - data%scale * unknown_change(data%anchors(i))
    end do
    do i_body = 1, merge(size(data%bodies), 0, size(changes) > 0)
      call derivative%create(data%bodies(i_body), theta, theta_change)
      do i = 1, size(changes)
        changes(i) = changes(i) + derivative%opening_of_row(data%bodies(i_body), forces, force_change, data%anchors(i))
      end do
    end do
  end function move_changes

  !> Computes the derivatives of the displacement of some exact dofs with respect to one parameter.
  subroutine interpolated_displacement_changes(data, theta, unknowns, gradient, i_parameter, places, changes)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, shape (n_multipliers); values on anchors do not count
    real(rk), intent(in) :: unknowns(:)
    !> result of differentiate_interpolated
    type(gradient_t), intent(in) :: gradient
    !> number of the parameter, 1-based
    integer, intent(in) :: i_parameter
    !> places among the exact dofs, 1-based
    integer, intent(in) :: places(:)
    !> [length per unit of the parameter] shape (size(places))
    real(rk), intent(out) :: changes(:)
    real(rk) :: forces(size(unknowns)), force_change(size(unknowns))
    type(body_derivative_t) :: derivative
    integer :: i, i_body, i_own

    forces = unknowns
    forces(data%anchors) = 0
    force_change = gradient%unknowns(:, i_parameter)
    force_change(data%anchors) = 0
    changes = matmul(data%anchor_motions(places, :), gradient%moves(:, i_parameter))
    do i_body = 1, size(data%bodies)
      associate (body => data%bodies(i_body))
        call derivative%create(body, theta, gradient%theta(:, i_parameter))
        do i = 1, size(places)
          i_own = place_in_ascending(body%own, places(i))
          if (i_own > 0) changes(i) = changes(i) + derivative%displacement_of(body, forces, force_change, i_own)
        end do
      end associate
    end do
  end subroutine interpolated_displacement_changes
end module sig_interpolated_derivative
