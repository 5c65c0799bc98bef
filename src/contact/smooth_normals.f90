! SPDX-License-Identifier: BSD-3-Clause
!> Normals of the smooth surface that the facets of a mesh stand for, from the places of the nodes: a parabola, in space a quadratic
!> surface, through a node and fitted to its neighbors by least squares. With the angle theta between neighboring facets these
!> normals err by theta**3, the means of facets' normals by theta.
module sig_smooth_normals
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  use sig_mesh, only: mesh_t, nodes_of_facet
  implicit none(type, external)
  private
  public :: fit_normals, normal_of_row

  !> [-] angles that are known at least and at most up to these errors, and the error of a normal that cannot be fitted
  real(rk), parameter :: least_error = 1.0e-6_rk, largest_error = 0.1_rk

contains

  !> Computes for each row the normal at its owner, and up to which angle it is certain: the square of the angle by which the
  !> surface bends between the owner and its neighbors. Where the direction is given, this is the normal, and certain.
  subroutine fit_normals(mesh, rows, group_of_entry, normals, errors)
    type(mesh_t), intent(in) :: mesh
    type(contact_rows_t), intent(in) :: rows
    !> index in mesh%groups of the surface of the owners of each contact entry; 0 where the deck gives the direction
    integer, intent(in) :: group_of_entry(:)
    !> unit vectors, shape (n_dim, n_rows)
    real(rk), allocatable, intent(out) :: normals(:, :)
    !> [rad] shape (n_rows)
    real(rk), allocatable, intent(out) :: errors(:)
    integer, allocatable :: starts(:), facets(:), owners(:)
    integer :: i_entry, k

    allocate (normals(rows%n_dim, rows%n_rows), errors(rows%n_rows))
    owners = rows%owners()
    do k = 1, rows%n_rows
      normals(:, k) = normal_of_row(rows, k)
      normals(:, k) = normals(:, k) / norm2(normals(:, k))
    end do
    errors = least_error
    do i_entry = 1, size(group_of_entry)
      if (group_of_entry(i_entry) == 0) cycle
      call list_facets(mesh, group_of_entry(i_entry), starts, facets)
      do k = 1, rows%n_rows
        if (rows%contact_entry(k) == i_entry) &
          call fit_normal(mesh%coordinates, owners(k), neighbors(mesh, owners(k), starts, facets), normals(:, k), errors(k))
      end do
    end do
  end subroutine fit_normals

  !> Returns the normal of a row: the sum of the coefficients of its first side.
  pure function normal_of_row(rows, k) result(normal)
    type(contact_rows_t), intent(in) :: rows
    !> 1-based
    integer, intent(in) :: k
    real(rk) :: normal(rows%n_dim)

    associate (first => rows%coefficients(rows%offsets(k) + 1:rows%splits(k)))
      normal = sum(reshape(first, [rows%n_dim, size(first) / rows%n_dim]), dim=2)
    end associate
  end function normal_of_row

  !> Lists the facets of a group around each node: facets(starts(i) + 1:starts(i + 1)).
  pure subroutine list_facets(mesh, i_group, starts, facets)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_group
    integer, allocatable, intent(out) :: starts(:), facets(:)
    integer :: i, n(mesh%n_nodes)

    n = 0
    associate (all => mesh%groups(i_group)%entities)
      do i = 1, size(all)
        associate (nodes => nodes_of_facet(mesh, all(i)))
          n(nodes) = n(nodes) + 1
        end associate
      end do
      allocate (starts(mesh%n_nodes + 1), source=0)
      do i = 1, mesh%n_nodes
        starts(i + 1) = starts(i) + n(i)
      end do
      allocate (facets(starts(mesh%n_nodes + 1)))
      n = starts(:mesh%n_nodes)
      do i = 1, size(all)
        associate (nodes => nodes_of_facet(mesh, all(i)))
          n(nodes) = n(nodes) + 1
          facets(n(nodes)) = all(i)
        end associate
      end do
    end associate
  end subroutine list_facets

  !> Returns the nodes of the facets around a node, without it; if there are too few for a fit with something to spare, also those
  !> of the facets around them.
  pure function neighbors(mesh, node, starts, facets) result(found)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: node
    !> of list_facets
    integer, intent(in) :: starts(:), facets(:)
    integer, allocatable :: found(:)
    integer :: i

    found = nodes_around(mesh, [node], starts, facets)
    if (size(found) <= merge(2, 6, mesh%n_dim == 2)) found = nodes_around(mesh, found, starts, facets)
    found = pack(found, [(found(i) /= node, i=1, size(found))])
  end function neighbors

  !> Returns the nodes of all facets around some nodes, each once.
  pure function nodes_around(mesh, nodes, starts, facets) result(found)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:), starts(:), facets(:)
    integer, allocatable :: found(:)
    integer, allocatable :: more(:)
    integer :: i, j, k

    found = nodes
    do i = 1, size(nodes)
      do j = starts(nodes(i)) + 1, starts(nodes(i) + 1)
        more = nodes_of_facet(mesh, facets(j))
        do k = 1, size(more)
          if (.not. any(found == more(k))) found = [found, more(k)]
        end do
      end do
    end do
  end function nodes_around

  !> Fits the normal of one node. Heights eta over the tangent plane of the given normal are fitted by g xi + xi' H xi / 2, where xi
  !> are the places in the plane over their largest size.
  subroutine fit_normal(coordinates, node, others, normal, error)
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    integer, intent(in) :: node, others(:)
    !> in: a unit vector close to the normal; out: the fitted one
    real(rk), intent(inout) :: normal(:)
    !> [rad]
    real(rk), intent(inout) :: error
    integer, parameter :: n_unknowns(2:3) = [2, 5]
    real(rk) :: tangents(size(normal), size(normal) - 1), places(size(normal) - 1, size(others)), heights(size(others))
    real(rk) :: columns(size(others), n_unknowns(size(normal))), answer(n_unknowns(size(normal))), reach
    logical :: is_singular
    integer :: i, n

    n = size(normal) - 1
    error = largest_error
    if (size(others) < size(answer)) return
    call span_plane(normal, tangents)
    do i = 1, size(others)
      associate (way => coordinates(:, others(i)) - coordinates(:, node))
        places(:, i) = matmul(way, tangents)
        heights(i) = dot_product(way, normal)
      end associate
    end do
    reach = maxval(norm2(places, dim=1))
    if (.not. reach > 0) return
    places = places / reach
    columns(:, :n) = transpose(places)
    columns(:, n + 1) = places(1, :)**2 / 2
    if (n == 2) then
      columns(:, 4) = places(1, :) * places(2, :)
      columns(:, 5) = places(2, :)**2 / 2
    end if
    ! the nearest neighbors count most
    do i = 1, size(others)
      associate (weight => 1 / max(0.1_rk, norm2(places(:, i)))**2)
        columns(i, :) = columns(i, :) * weight
        heights(i) = heights(i) * weight / reach
      end associate
    end do
    call solve_dense(matmul(transpose(columns), columns), matmul(heights, columns), answer, is_singular)
    if (is_singular) return
    normal = normal - matmul(tangents, answer(:n))
    normal = normal / norm2(normal)
    error = min(largest_error, max(least_error, sum(answer(n + 1:)**2)))
  end subroutine fit_normal

  !> Computes orthonormal vectors across a unit vector, one per column.
  pure subroutine span_plane(normal, tangents)
    real(rk), intent(in) :: normal(:)
    real(rk), intent(out) :: tangents(:, :)
    integer :: i

    if (size(normal) == 2) then
      tangents(:, 1) = [-normal(2), normal(1)]
      return
    end if
    i = minloc(abs(normal), dim=1)
    tangents(:, 1) = -normal(i) * normal
    tangents(i, 1) = tangents(i, 1) + 1
    tangents(:, 1) = tangents(:, 1) / norm2(tangents(:, 1))
    associate (a => normal, b => tangents(:, 1))
      tangents(:, 2) = [a(2) * b(3) - a(3) * b(2), a(3) * b(1) - a(1) * b(3), a(1) * b(2) - a(2) * b(1)]
    end associate
  end subroutine span_plane
end module sig_smooth_normals
