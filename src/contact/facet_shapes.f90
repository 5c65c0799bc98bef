! SPDX-License-Identifier: BSD-3-Clause
!> Facets of two surfaces as maps from a reference element: their parts with straight edges, and the way back from a place.
module sig_facet_shapes
  use sig_changed_basis, only: changed_basis
  use sig_element_types, only: element_types, n_element_types
  use sig_kinds, only: rk
  use sig_quadrature, only: quadrature_rule
  use sig_shape_functions, only: shape_coefficients, shape_slopes, shape_values
  implicit none(type, external)
  private
  public :: facet_shape_t, create_shapes, max_corners

  !> largest number of corners of a part
  integer, parameter :: max_corners = 4

  !> What all facets of one element type have in common.
  type :: facet_shape_t
    !> row of element_types; 0 = not a facet of this dimension
    integer :: i_type = 0
    !> [-] result of shape_coefficients
    real(rk), allocatable :: coefficients(:, :)
    !> [-] a place of the reference element, inside, where a search starts
    real(rk), allocatable :: middle(:)
    !> corners of the parts whose edges count as straight, as numbers of the facet's nodes (1-based), filled up with 0; shape
    !> (max_corners, n_parts)
    integer, allocatable :: parts(:, :)
    !> [-] the basis of positive integrals, as combinations of the shape functions
    real(rk), allocatable :: changed_basis(:, :)
    !> [-] integration points and weights of the whole reference element, by quadrature_rule
    real(rk), allocatable :: points(:, :)
    real(rk), allocatable :: weights(:)
  contains
    procedure :: values
    procedure :: tangents
    procedure :: find_place
  end type facet_shape_t

  !> [-] share of the facet's extent: a place is found if it is as near as this
  real(rk), parameter :: near_enough = 1.0e-13_rk
  !> [-] in the reference element: no place of use lies as far outside
  real(rk), parameter :: far_outside = 100.0_rk

contains

  !> Makes the data of all facet types for meshes of a dimension: entry i belongs to row i of element_types, and stays empty with
  !> i_type = 0 if elements of this row are no facets of such a mesh.
  pure subroutine create_shapes(n_dim, shapes)
    !> dimension of the mesh, 2 or 3
    integer, intent(in) :: n_dim
    type(facet_shape_t), intent(out) :: shapes(n_element_types)
    integer :: i_type

    do i_type = 1, n_element_types
      if (element_types(i_type)%n_dim == n_dim - 1) call create_shape(i_type, shapes(i_type))
    end do
  end subroutine create_shapes

  pure subroutine create_shape(i_type, shape)
    integer, intent(in) :: i_type
    type(facet_shape_t), intent(out) :: shape

    associate (element => element_types(i_type))
      shape%i_type = i_type
      shape%coefficients = shape_coefficients(i_type)
      shape%middle = sum(element%reference_nodes(:element%n_dim, :element%n_corners), dim=2) / element%n_corners
      shape%changed_basis = changed_basis(i_type)
      shape%parts = parts_of(element%n_dim, element%n_corners, element%n_nodes)
      call quadrature_rule(i_type, shape%points, shape%weights)
    end associate
  end subroutine create_shape

  !> Returns the nodes of the parts of a facet. A linear facet is its own part. A quadratic one is cut at its mid-side nodes, so
  !> that neighbors still fit together: an edge into two; a face with a central node into a part at each corner; any other face into
  !> a part at each corner and one between its mid-side nodes.
  pure function parts_of(n_dim, n_corners, n_nodes) result(parts)
    !> dimension of the facet, and numbers of its corners and nodes
    integer, intent(in) :: n_dim, n_corners, n_nodes
    !> corners of the parts, as numbers of the facet's nodes (1-based), filled up with 0; shape (max_corners, n_parts)
    integer, allocatable :: parts(:, :)
    integer :: i, n

    n = n_corners
    if (n_nodes == n) then
      parts = reshape([(i, i=1, n)], [max_corners, 1], [0])
    else if (n_dim == 1) then
      parts = reshape([1, 3, 0, 0, 3, 2, 0, 0], [max_corners, 2])
    else if (n_nodes == 2 * n) then
      parts = reshape([([i, n + i, n + 1 + modulo(i - 2, n), 0], i=1, n), [(n + i, i=1, n)]], [max_corners, n + 1], [0])
    else
      parts = reshape([([i, n + i, n_nodes, n + 1 + modulo(i - 2, n)], i=1, n)], [max_corners, n])
    end if
  end function parts_of

  !> Returns the shape functions at a place of the reference element, shape (n_nodes).
  pure function values(self, place)
    class(facet_shape_t), intent(in) :: self
    !> [-] shape (dimension of the facet)
    real(rk), intent(in) :: place(:)
    real(rk) :: values(size(self%coefficients, 2))

    values = shape_values(self%i_type, self%coefficients, place)
  end function values

  !> Returns the derivatives [length] of the place in space along each direction of the reference element, shape (components,
  !> n_dim), where n_dim is the dimension of the facet.
  pure function tangents(self, vertices, place)
    class(facet_shape_t), intent(in) :: self
    !> [length] shape (components, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    !> [-] in the reference element, shape (n_dim)
    real(rk), intent(in) :: place(:)
    real(rk) :: tangents(size(vertices, 1), size(place))
    integer :: i_dim

    do i_dim = 1, size(place)
      tangents(:, i_dim) = matmul(vertices, shape_slopes(self%i_type, self%coefficients, place, i_dim))
    end do
  end function tangents

  !> Finds the place of the reference element that belongs to a point, by Newton's method. The facet is projected to as many
  !> components as it has dimensions (n_dim). is_found is false if the method does not converge in 30 steps, or leads to a place
  !> with a coordinate above 100 in size.
  pure subroutine find_place(self, flat, point, place, is_found)
    class(facet_shape_t), intent(in) :: self
    !> [length] places of the facet's nodes in this projection, shape (n_dim, n_nodes)
    real(rk), intent(in) :: flat(:, :)
    !> [length] the point in this projection, shape (n_dim)
    real(rk), intent(in) :: point(:)
    !> [-] may lie outside of the reference element; of no use if is_found is false
    real(rk), intent(out) :: place(:)
    logical, intent(out) :: is_found
    integer, parameter :: most_steps = 30
    real(rk) :: determinant, extent, rest(size(point)), slopes(size(point), size(point))
    integer :: i_step

    extent = maxval(maxval(flat, dim=2) - minval(flat, dim=2))
    place = self%middle
    do i_step = 1, most_steps
      rest = point - matmul(flat, self%values(place))
      is_found = maxval(abs(rest)) <= near_enough * extent
      if (is_found) return
      slopes = self%tangents(flat, place)
      if (size(point) == 1) then
        determinant = slopes(1, 1)
        if (abs(determinant) > near_enough * extent) place = place + rest / determinant
      else
        determinant = slopes(1, 1) * slopes(2, 2) - slopes(1, 2) * slopes(2, 1)
        if (abs(determinant) > near_enough * extent**2) place = place + [slopes(2, 2) * rest(1) - slopes(1, 2) * rest(2), &
          slopes(1, 1) * rest(2) - slopes(2, 1) * rest(1)] / determinant
      end if
      if (maxval(abs(place)) > far_outside) return
    end do
  end subroutine find_place
end module sig_facet_shapes
