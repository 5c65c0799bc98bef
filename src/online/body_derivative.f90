! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of one body's responses with respect to the terms, by the product rule. Responses to forces are (1/s) M(c) x, those
!> to prescribed displacements are M(c) x; s is the scale of the body's moduli, and c are its interpolated constants.
module sig_body_derivative
  use sig_body_response, only: body_response_t, sum_of_row
  use sig_interpolated_constants, only: variable_change
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  implicit none(type, external)
  private
  public :: body_derivative_t

  !> The values of a body's scale, interpolation weights and terms at a point, and their changes for a given change of the terms.
  type :: body_derivative_t
    !> [-] s and ds/s
    real(rk) :: modulus_ratio = 1
    real(rk) :: relative_change = 0
    !> [-] weight of each node of the interpolation, and its change; shape (n_nodes)
    real(rk), allocatable :: weights(:)
    real(rk), allocatable :: weight_changes(:)
    !> values of the terms and their changes, shape (n_terms)
    real(rk), allocatable :: theta(:)
    real(rk), allocatable :: theta_change(:)
  contains
    procedure :: create
    procedure :: add_opening
    procedure :: opening_of_row
    procedure :: displacement_of
  end type body_derivative_t

contains

  !> Computes the values of the body's scale and interpolation weights at a point, and their changes, to first order, for a given
  !> change of the terms. It keeps copies of theta and theta_change. Requires: nodes%prepare of the body.
  subroutine create(self, body, theta, theta_change)
    class(body_derivative_t), intent(out) :: self
    type(body_response_t), intent(in) :: body
    !> values of the terms, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> changes of the terms, same shape
    real(rk), contiguous, intent(in) :: theta_change(:)
    real(rk) :: changes(size(body%numerators)), constants(size(body%numerators))

    self%theta = theta
    self%theta_change = theta_change
    self%modulus_ratio = body%modulus_ratio(theta)
    self%relative_change = theta_change(body%modulus_term) / theta(body%modulus_term)
    allocate (self%weights(body%nodes%n_nodes()), self%weight_changes(body%nodes%n_nodes()))
    call body%weights_at(theta, self%weights)
    call find_constants(body, theta, theta_change, constants, changes)
    call body%nodes%weight_changes(body%variables_at(theta), &
      variable_change(constants, changes, body%denominators > 0, body%is_logarithmic), self%weight_changes)
  end subroutine create

  !> Computes the constants over which the responses of a body are interpolated, which are elastic constants or ratios of two of
  !> them, never logarithms. Computes also their changes, to first order, for a change of the terms.
  pure subroutine find_constants(body, theta, theta_change, constants, changes)
    type(body_response_t), intent(in) :: body
    !> values of the terms and their changes, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)
    !> [-] shape (n_variables)
    real(rk), intent(out) :: constants(:)
    real(rk), intent(out) :: changes(:)
    integer :: i

    do i = 1, size(constants)
      associate (above => body%numerators(i), below => body%denominators(i))
        constants(i) = theta(above)
        changes(i) = theta_change(above)
        if (below == 0) cycle
        constants(i) = theta(above) / theta(below)
        changes(i) = (theta_change(above) - constants(i) * theta_change(below)) / theta(below)
      end associate
    end do
  end subroutine find_constants

  !> Adds to `opening` the body's part of the change of W z + q, if the terms change as given to create and z stays constant. Rows
  !> of anchors are those of open anchors, and the change of the gaps D is left out.
  subroutine add_opening(self, body, forces, opening)
    class(body_derivative_t), intent(in) :: self
    !> the body that create was called with
    type(body_response_t), intent(in) :: body
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    integer :: n_driving

    n_driving = size(body%loaded_opening, 1) / max(1, size(opening))
    call add_change(self, body%compliance, forces, 0 * forces, opening)
    call add_change(self, body%loaded_opening, self%theta(:n_driving), self%theta_change(:n_driving), opening)
    call add_prescribed(self, body%prescribed_opening, self%theta(:n_driving), self%theta_change(:n_driving), opening)
  end subroutine add_opening

  !> Adds the change of (1/s) M x to y, where M is interpolated, and s and the weights of the interpolation change as in `self`.
  subroutine add_change(self, columns, x, x_change, y)
    type(body_derivative_t), intent(in) :: self
    !> M at the nodes of the interpolation, column by column; shape (size(y) * size(x), n_nodes)
    real(rk), contiguous, intent(in) :: columns(:, :)
    !> x and its change dx
    real(rk), intent(in) :: x(:)
    real(rk), intent(in) :: x_change(:)
    real(rk), contiguous, intent(inout) :: y(:)

    call add_interpolated(columns, self%weight_changes, x / self%modulus_ratio, y)
    call add_interpolated(columns, self%weights, (x_change - self%relative_change * x) / self%modulus_ratio, y)
  end subroutine add_change

  !> Adds the change of M x to y, where M is interpolated and does not depend on s.
  subroutine add_prescribed(self, columns, x, x_change, y)
    type(body_derivative_t), intent(in) :: self
    !> as for add_change
    real(rk), contiguous, intent(in) :: columns(:, :)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk), contiguous, intent(in) :: x_change(:)
    real(rk), contiguous, intent(inout) :: y(:)

    call add_interpolated(columns, self%weight_changes, x, y)
    call add_interpolated(columns, self%weights, x_change, y)
  end subroutine add_prescribed

  !> Computes y = y + M x, where M is the sum of `columns` times `weights` over the nodes.
  subroutine add_interpolated(columns, weights, x, y)
    !> a matrix per node, column by column; shape (size(y) * size(x), n_nodes)
    real(rk), contiguous, intent(in) :: columns(:, :)
    real(rk), contiguous, intent(in) :: weights(:)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk), contiguous, intent(inout) :: y(:)
    real(rk) :: matrix(size(y), size(x)), flat(size(columns, 1))

    ! a parameter changes few bodies, so the weights or x are often zero
    if (.not. (any(abs(weights) > 0) .and. any(abs(x) > 0))) return
    call multiply(1.0_rk, columns, weights, 0.0_rk, flat)
    matrix = reshape(flat, shape(matrix))
    call multiply(1.0_rk, matrix, x, 1.0_rk, y)
  end subroutine add_interpolated

  !> Returns the body's part [length] of the change of one row of W z + q, if z changes by dz and the terms as given to create. The
  !> change of the gaps D is left out.
  pure real(rk) function opening_of_row(self, body, forces, force_change, row) result(change)
    class(body_derivative_t), intent(in) :: self
    !> the body that create was called with
    type(body_response_t), intent(in) :: body
    !> [force] z and dz, zero on anchors; shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    real(rk), intent(in) :: force_change(:)
    !> row among the multipliers, 1-based; the row of an anchor is that of the open anchor
    integer, intent(in) :: row

    change = change_of_row(self, size(forces), row, body%loaded_opening, body%prescribed_opening) + &
      change_in_row(self, size(forces), row, body%compliance, forces, force_change)
  end function opening_of_row

  !> Returns the change [length] of the displacement of one of the body's exact dofs, where z changes by dz and the terms as given
  !> to create. Rigid motions of the anchors are left out.
  pure real(rk) function displacement_of(self, body, forces, force_change, i) result(change)
    class(body_derivative_t), intent(in) :: self
    !> the body that create was called with
    type(body_response_t), intent(in) :: body
    !> [force] z and dz, zero on anchors; shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    real(rk), intent(in) :: force_change(:)
    !> place in body%own, 1-based
    integer, intent(in) :: i

    change = change_of_row(self, size(body%own), i, body%loaded_field, body%prescribed_field) - &
      change_in_row(self, size(body%own), i, body%contact_field, forces, force_change)
  end function displacement_of

  !> Returns the change of one row of (loaded / s + prescribed) theta(:n_driving_terms), with theta and its change from `self`.
  pure real(rk) function change_of_row(self, n, row, loaded, prescribed) result(change)
    type(body_derivative_t), intent(in) :: self
    !> number of rows of the matrices
    integer, intent(in) :: n
    !> 1-based
    integer, intent(in) :: row
    !> each matrix at the nodes, column by column; shape (n * n_driving_terms, n_nodes)
    real(rk), intent(in) :: loaded(:, :)
    real(rk), intent(in) :: prescribed(:, :)

    associate (leading => self%theta(:size(loaded, 1) / n), leading_change => self%theta_change(:size(loaded, 1) / n))
      change = change_in_row(self, n, row, loaded, leading, leading_change) + &
        sum_of_row(n, row, prescribed, self%weight_changes, leading) + sum_of_row(n, row, prescribed, self%weights, leading_change)
    end associate
  end function change_of_row

  !> Returns the change of one row of (1/s) M x, where x changes by x_change. Other arguments: sum_of_row of sig_body_response.
  pure real(rk) function change_in_row(self, n, row, columns, x, x_change) result(change)
    type(body_derivative_t), intent(in) :: self
    integer, intent(in) :: n
    integer, intent(in) :: row
    real(rk), intent(in) :: columns(:, :)
    real(rk), intent(in) :: x(:)
    real(rk), intent(in) :: x_change(:)

    change = (sum_of_row(n, row, columns, self%weight_changes, x) + &
      sum_of_row(n, row, columns, self%weights, x_change - self%relative_change * x)) / self%modulus_ratio
  end function change_in_row
end module sig_body_derivative
