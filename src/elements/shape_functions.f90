! SPDX-License-Identifier: BSD-3-Clause
!> Shape functions of all element types of the table, from their monomials and reference nodes.
!>
!> N_i(xi) = sum_j c_ji m_j(xi) with the monomials m_j. The coefficients c follow from sum_j m_j(reference node k) c_ji = delta_ik
!> by one small inverse, so the element types need no formulas of their own.
module sig_shape_functions
  use sig_element_types, only: corner_type, element_type_t, element_types
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: shape_table_t, create_shape_table, shape_coefficients, shape_values, shape_slopes, corners_of_node

  !> Shape functions and their gradients at the quadrature points of one element type.
  type :: shape_table_t
    integer :: n_points = 0
    !> [-] shape (n_points), sum = volume of the reference element
    real(rk), allocatable :: weights(:)
    !> [-] shape (n_nodes, n_points)
    real(rk), allocatable :: values(:, :)
    !> [-] d N_i / d xi_d, shape (n_dim, n_nodes, n_points)
    real(rk), allocatable :: gradients(:, :, :)
    !> [-] factors that give values at the nodes of a quadratic element from values at the points; not allocated for linear
    !> elements, or with fewer points than corners; shape (n_nodes, n_points)
    real(rk), allocatable :: to_nodes(:, :)
  end type shape_table_t

contains

  !> Computes the shape functions of an element type at the given integration points, their gradients with respect to the reference
  !> coordinates, and to_nodes (see extrapolate). Copies the weights.
  pure subroutine create_shape_table(i_type, points, weights, table)
    !> row of element_types
    integer, intent(in) :: i_type
    !> [-] points of the reference element, shape (n_dim, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [-] weights of the points, shape (n_points)
    real(rk), intent(in) :: weights(:)
    type(shape_table_t), intent(out) :: table
    real(rk), allocatable :: coefficients(:, :)
    integer :: i_dim, i_point

    associate (n_dim => element_types(i_type)%n_dim, n_nodes => element_types(i_type)%n_nodes)
      coefficients = shape_coefficients(i_type)
      table%n_points = size(weights)
      table%weights = weights
      allocate (table%values(n_nodes, size(weights)))
      allocate (table%gradients(n_dim, n_nodes, size(weights)))
      do i_point = 1, size(weights)
        table%values(:, i_point) = shape_values(i_type, coefficients, points(:, i_point))
        do i_dim = 1, n_dim
          table%gradients(i_dim, :, i_point) = shape_slopes(i_type, coefficients, points(:, i_point), i_dim)
        end do
      end do
      call extrapolate(i_type, points, weights, table%to_nodes)
    end associate
  end subroutine create_shape_table

  !> Computes shape_table_t%to_nodes for a quadratic element: a field of the linear element of the same shape is fitted to the
  !> values at the points by least squares with these weights. to_nodes is not allocated for linear elements, or with fewer points
  !> than corners. Source: E. Hinton, J. S. Campbell, Int. J. for Num. Methods in Engineering 8 (1974) 461.
  pure subroutine extrapolate(i_type, points, weights, to_nodes)
    integer, intent(in) :: i_type
    real(rk), intent(in) :: points(:, :)
    real(rk), intent(in) :: weights(:)
    !> [-] shape (n_nodes, n_points)
    real(rk), allocatable, intent(out) :: to_nodes(:, :)
    real(rk), allocatable :: at_points(:, :), coefficients(:, :), inverse(:, :)
    integer :: i

    associate (element => element_types(i_type), i_corners => corner_type(i_type))
      if (element%order == 1 .or. size(weights) < element%n_corners) return
      allocate (to_nodes(element%n_nodes, size(weights)))
      coefficients = shape_coefficients(i_corners)
      allocate (at_points(element%n_corners, size(weights)))
      do i = 1, size(weights)
        at_points(:, i) = shape_values(i_corners, coefficients, points(:, i))
      end do
      inverse = inverted(matmul(at_points, transpose(at_points) * spread(weights, 2, element%n_corners)))
      do i = 1, element%n_nodes
        to_nodes(i, :) = weights * matmul(matmul(shape_values(i_corners, coefficients, &
          element%reference_nodes(:element%n_dim, i)), inverse), at_points)
      end do
    end associate
  end subroutine extrapolate

  !> Returns the coefficients c [-] of the shape functions, shape (n_nodes, n_nodes): shape function i is the sum over j of c(j, i)
  !> times monomial j of the element type.
  pure function shape_coefficients(i_type) result(coefficients)
    !> row of element_types
    integer, intent(in) :: i_type
    real(rk), allocatable :: coefficients(:, :)
    real(rk) :: at_nodes(element_types(i_type)%n_nodes, element_types(i_type)%n_nodes)
    integer :: i_node

    associate (element => element_types(i_type))
      do i_node = 1, element%n_nodes
        at_nodes(i_node, :) = monomial_values(element, element%reference_nodes(:element%n_dim, i_node), 0)
      end do
    end associate
    coefficients = inverted(at_nodes)
  end function shape_coefficients

  !> Returns the inverse of a matrix by elimination with row exchanges. The matrices of the elements are never singular.
  pure function inverted(matrix) result(inverse)
    !> square
    real(rk), intent(in) :: matrix(:, :)
    real(rk) :: inverse(size(matrix, 1), size(matrix, 1))
    real(rk) :: rows(size(matrix, 1), 2 * size(matrix, 1))
    integer :: i, k, n, pivot

    n = size(matrix, 1)
    rows = 0
    rows(:, :n) = matrix
    do k = 1, n
      rows(k, n + k) = 1
    end do
    do k = 1, n
      pivot = k - 1 + maxloc(abs(rows(k:, k)), dim=1)
      rows([k, pivot], :) = rows([pivot, k], :)
      rows(k, :) = rows(k, :) / rows(k, k)
      do i = 1, n
        if (i /= k) rows(i, :) = rows(i, :) - rows(i, k) * rows(k, :)
      end do
    end do
    inverse = rows(:, n + 1:)
  end function inverted

  !> Returns the values [-] of the shape functions at a point of the reference element, shape (n_nodes).
  pure function shape_values(i_type, coefficients, point) result(values)
    !> row of element_types
    integer, intent(in) :: i_type
    !> from shape_coefficients
    real(rk), intent(in) :: coefficients(:, :)
    !> [-] shape (n_dim)
    real(rk), intent(in) :: point(:)
    real(rk) :: values(size(coefficients, 2))

    values = matmul(monomial_values(element_types(i_type), point, 0), coefficients)
  end function shape_values

  !> Returns the derivatives [-] of the shape functions with respect to one reference coordinate, shape (n_nodes).
  pure function shape_slopes(i_type, coefficients, point, i_dim) result(slopes)
    !> row of element_types
    integer, intent(in) :: i_type
    !> from shape_coefficients
    real(rk), intent(in) :: coefficients(:, :)
    !> [-] shape (n_dim)
    real(rk), intent(in) :: point(:)
    !> number of the coordinate: 1 = xi, 2 = eta, 3 = zeta
    integer, intent(in) :: i_dim
    real(rk) :: slopes(size(coefficients, 2))

    slopes = matmul(monomial_values(element_types(i_type), point, i_dim), coefficients)
  end function shape_slopes

  !> Returns the numbers (1-based, ascending) of the corners of the edge, the face or the cell in whose middle a node is; for a
  !> corner the corner itself.
  pure function corners_of_node(i_type, i_node) result(corners)
    !> row of element_types
    integer, intent(in) :: i_type
    !> node of the element, 1-based
    integer, intent(in) :: i_node
    integer, allocatable :: corners(:)
    !> [-] at such a node, the linear shape functions of these corners are at least 1/8, and those of the others are 0
    real(rk), parameter :: smallest_share = 0.1_rk
    integer :: i

    associate (element => element_types(i_type), i_linear => corner_type(i_type))
      corners = pack([(i, i=1, element%n_corners)], shape_values(i_linear, shape_coefficients(i_linear), &
        element%reference_nodes(:element%n_dim, i_node)) > smallest_share)
    end associate
  end function corners_of_node

  !> Returns the values of the element's monomials at a point, or their derivatives with respect to one reference coordinate. At the
  !> apex of a pyramid the derivatives are those along its axis.
  pure function monomial_values(element, point, derivative) result(values)
    type(element_type_t), intent(in) :: element
    real(rk), intent(in) :: point(:)
    !> number of this coordinate, 1-based; 0 = the values
    integer, intent(in) :: derivative
    real(rk) :: values(element%n_nodes)
    real(rk) :: ratio, slope
    integer :: i

    ratio = 1
    slope = 0
    if (any(element%ratio_powers > 0)) call find_ratio(point, derivative, ratio, slope)
    do i = 1, element%n_nodes
      associate (powers => element%monomials(:element%n_dim, i), ratio_power => element%ratio_powers(i))
        values(i) = monomial(point, powers, derivative) * ratio**ratio_power
        if (derivative > 0 .and. ratio_power > 0) &
          values(i) = values(i) + monomial(point, powers, 0) * ratio_power * ratio**(ratio_power - 1) * slope
      end associate
    end do
  end function monomial_values

  !> Returns the product of powers of the coordinates, or its derivative with respect to one of them.
  pure real(rk) function monomial(point, powers, derivative) result(value)
    real(rk), intent(in) :: point(:)
    integer, intent(in) :: powers(:)
    !> number of this coordinate, 1-based; 0 = the value
    integer, intent(in) :: derivative
    integer :: i_dim

    value = 1
    do i_dim = 1, size(powers)
      if (i_dim /= derivative) then
        value = value * point(i_dim)**powers(i_dim)
      else if (powers(i_dim) == 0) then
        value = 0
      else
        value = value * powers(i_dim) * point(i_dim)**(powers(i_dim) - 1)
      end if
    end do
  end function monomial

  !> Computes the ratio w = xi eta / (1 - zeta) of a pyramid and its derivative with respect to one coordinate. On the axis both are
  !> 0, at the apex, too, where the derivative depends on the direction from which one comes.
  pure subroutine find_ratio(point, derivative, ratio, slope)
    !> [-] shape (3)
    real(rk), intent(in) :: point(:)
    !> number of the coordinate, 1-based; 0: slope is 0
    integer, intent(in) :: derivative
    real(rk), intent(out) :: ratio
    real(rk), intent(out) :: slope
    real(rk) :: place(2), slopes(0:3)

    place = 0
    if (abs(1 - point(3)) > 0) place = point(:2) / (1 - point(3))
    ratio = place(1) * place(2) * (1 - point(3))
    slopes = [0.0_rk, place(2), place(1), place(1) * place(2)]
    slope = slopes(derivative)
  end subroutine find_ratio
end module sig_shape_functions
