! SPDX-License-Identifier: BSD-3-Clause
!> A changed basis for the functions on a quadratic facet. All its functions have positive integrals; some shape functions have not.
!>
!> The shape function of a corner has the integral 0 on a face of six nodes, and -1/12 of the area on a face of eight nodes. In the
!> changed basis a part alpha of the functions of the two neighboring mid-side nodes is added to it: N~_corner = N_corner + alpha
!> (N_before + N_after), N~_mid = (1 - 2 alpha) N_mid. The sum of all functions stays 1. A field has the coefficients u~_corner =
!> u_corner and u~_mid = (u_mid - alpha (u_a + u_b)) / (1 - 2 alpha), where a and b are the corners at the ends of the side. Source:
!> Popp, Wohlmuth, Gee, Wall, SIAM J. Sci. Comput. 34 (2012) B421.
module sig_changed_basis
  use sig_element_types, only: element_types
  use sig_kinds, only: rk
  use sig_quadrature, only: quadrature_rule
  use sig_rounding, only: rounding
  use sig_shape_functions, only: corners_of_node, create_shape_table, shape_table_t
  implicit none(type, external)
  private
  public :: has_weak_corners, changed_basis, ends_of_side, owner_weight, end_weight

  !> [-] it gives integrals of N~_corner and N~_mid of 2/15 and 1/5 of the area for six nodes, of 1/20 and 1/5 for eight nodes
  real(rk), parameter :: alpha = 0.2_rk
  !> [-] factors of u_mid, and of u_a and u_b, in the coefficient u~_mid
  real(rk), parameter :: owner_weight = 1 / (1 - 2 * alpha)
  real(rk), parameter :: end_weight = -alpha / (1 - 2 * alpha)

contains

  !> Whether the integral of some shape function over the reference element is zero or negative. Of the facets, this is so for T6
  !> and Q8 only.
  pure logical function has_weak_corners(i_type)
    !> row of element_types
    integer, intent(in) :: i_type
    type(shape_table_t) :: table
    real(rk), allocatable :: points(:, :), weights(:)

    has_weak_corners = .false.
    if (element_types(i_type)%order == 1) return
    call quadrature_rule(i_type, points, weights)
    call create_shape_table(i_type, points, weights, table)
    has_weak_corners = minval(matmul(table%values, weights)) <= rounding
  end function has_weak_corners

  !> Returns the matrix that gives the functions of the changed basis from the shape functions, N~ = matrix N, with alpha = 0.2. All
  !> mid-side nodes count, whether has_weak_corners is true or not. For elements without mid-side nodes it is the identity.
  pure function changed_basis(i_type) result(matrix)
    !> row of element_types
    integer, intent(in) :: i_type
    !> [-] shape (n_nodes, n_nodes)
    real(rk) :: matrix(element_types(i_type)%n_nodes, element_types(i_type)%n_nodes)
    integer :: ends(2), i

    matrix = 0
    do i = 1, size(matrix, 1)
      matrix(i, i) = 1
      ends = ends_of_side(i_type, i)
      if (ends(1) == 0) cycle
      matrix(i, i) = 1 - 2 * alpha
      matrix(ends, i) = alpha
    end do
  end function changed_basis

  !> Returns the numbers (1-based, ascending) of the two corners at the ends of the side in whose middle a node is; zeros for a node
  !> that is not in the middle of a side.
  pure function ends_of_side(i_type, i_node) result(ends)
    !> row of element_types
    integer, intent(in) :: i_type
    !> node of the element, 1-based
    integer, intent(in) :: i_node
    integer :: ends(2)

    ends = 0
    associate (corners => corners_of_node(i_type, i_node))
      if (size(corners) == 2) ends = corners
    end associate
  end function ends_of_side
end module sig_changed_basis
