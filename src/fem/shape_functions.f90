! SPDX-License-Identifier: BSD-3-Clause
!> Shape functions of every element type of the table, from its monomials and reference nodes.
!>
!> N_i(xi) = sum_j c_ji m_j(xi) with m_j(reference node k) c_ji = delta_ik: one small inverse replaces a branch per element.
module sig_shape_functions
  use sig_element_types, only: element_type_t, element_types
  use sig_kinds, only: rk
  use sig_linear_algebra, only: invert
  implicit none(type, external)
  private
  public :: shape_table_t, create_shape_table

  !> Shape functions and their gradients at the quadrature points of one element type.
  type :: shape_table_t
    integer :: n_points = 0
    !> [-] shape (n_points), sum = volume of the reference element
    real(rk), allocatable :: weights(:)
    !> [-] shape (n_nodes, n_points)
    real(rk), allocatable :: values(:, :)
    !> [-] d N_i / d xi_d, shape (n_dim, n_nodes, n_points)
    real(rk), allocatable :: gradients(:, :, :)
  end type shape_table_t

contains

  !> Tabulates one row of element_types at the given points of its reference element.
  subroutine create_shape_table(i_type, points, weights, table)
    integer, intent(in) :: i_type
    !> [-] shape (n_dim, n_points)
    real(rk), intent(in) :: points(:, :)
    real(rk), intent(in) :: weights(:)
    type(shape_table_t), intent(out) :: table
    real(rk), allocatable :: coefficients(:, :)
    integer :: i_dim, i_point

    associate (element => element_types(i_type))
      coefficients = shape_coefficients(element)
      table%n_points = size(weights)
      table%weights = weights
      allocate (table%values(element%n_nodes, size(weights)))
      allocate (table%gradients(element%n_dim, element%n_nodes, size(weights)))
      do i_point = 1, size(weights)
        table%values(:, i_point) = matmul(monomial_values(element, points(:, i_point), 0), coefficients)
        do i_dim = 1, element%n_dim
          table%gradients(i_dim, :, i_point) = matmul(monomial_values(element, points(:, i_point), i_dim), coefficients)
        end do
      end do
    end associate
  end subroutine create_shape_table

  !> c of the formula in the head of this file, shape (n_nodes, n_nodes).
  function shape_coefficients(element) result(coefficients)
    type(element_type_t), intent(in) :: element
    real(rk), allocatable :: coefficients(:, :)
    real(rk) :: at_nodes(element%n_nodes, element%n_nodes)
    integer :: i_node
    logical :: is_singular

    do i_node = 1, element%n_nodes
      at_nodes(i_node, :) = monomial_values(element, element%reference_nodes(:element%n_dim, i_node), 0)
    end do
    allocate (coefficients(element%n_nodes, element%n_nodes))
    call invert(at_nodes, coefficients, is_singular)
  end function shape_coefficients

  !> Monomials at a point, or their derivative along one direction (derivative = 0: the values).
  pure function monomial_values(element, point, derivative) result(values)
    type(element_type_t), intent(in) :: element
    real(rk), intent(in) :: point(:)
    integer, intent(in) :: derivative
    real(rk) :: values(element%n_nodes)
    integer :: i_dim, i_monomial, power

    values = 1
    do i_monomial = 1, element%n_nodes
      do i_dim = 1, element%n_dim
        power = element%monomials(i_dim, i_monomial)
        if (i_dim /= derivative) then
          values(i_monomial) = values(i_monomial) * point(i_dim)**power
        else if (power == 0) then
          values(i_monomial) = 0
        else
          values(i_monomial) = values(i_monomial) * power * point(i_dim)**(power - 1)
        end if
      end do
    end do
  end function monomial_values
end module sig_shape_functions
