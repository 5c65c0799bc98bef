! SPDX-License-Identifier: BSD-3-Clause
!> How far the normals of contact rows lean from the surface that they face.
!>
!> Displacements are small, so a row keeps the normal n that its node has in the mesh. Where a curved surface is pressed far, its
!> nodes meet the other surface under an angle a to the normal m of this surface. The gap along n is d / cos a, where d is the
!> distance along m; a motion along m closes it by cos a of its size. So the row closes after the motion d (1 + tan(a)**2), and its
!> force acts under the angle a. A squeezed cylinder has a total force that is too small by 2 to 2.5 times the mean of tan(a)**2,
!> weighted by the forces. On a bed of springs it is 2.5: with x = a R and the squeeze s = X**2 / 2R, the forces are s - x**2 / 2R,
!> and s cos(a)**2 - x**2 / 2R along n; integrals over x < X give a loss of X**2 / 2R**2, and a mean of X**2 / 5R**2.
module sig_leaning_rows
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_smooth_normals, only: normal_of_row
  use sig_surface_geometry, only: averaged_normals, is_flat, measure_surface, normal_in_symmetry, surface_geometry_t
  implicit none(type, external)
  private
  public :: measure_leans, mean_lean

  !> [-] cosine of the largest angle that counts: beyond it surfaces do not face each other
  real(rk), parameter :: least_cosine = 0.1_rk

contains

  !> Sets tan(a)**2 of the rows of one contact entry. The angle a is that between the normal of the row and the averaged normal of
  !> the other surface at the row's nodes on it, or the one between the normal of the row and the common normal where both surfaces
  !> are most parallel, which is where convex bodies touch first: the smaller one of both, because two equal cylinders share the
  !> angle between them. It is 0 where the surface of the owners is flat, because its normals are right then.
  pure subroutine measure_leans(mesh, rows, i_entry, groups, is_prescribed, leans, common)
    type(mesh_t), intent(in) :: mesh
    type(contact_rows_t), intent(in) :: rows
    !> number of the entry in the deck, 1-based
    integer, intent(in) :: i_entry
    !> indices in mesh%groups of the surface of the owners and of the other one
    integer, intent(in) :: groups(2)
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> [-] shape (n_rows); of other entries it stays
    real(rk), intent(inout) :: leans(:)
    !> [-] the common normal, from the surface of the owners to the other one; 0 where all leans are 0
    real(rk), intent(out) :: common(:)
    type(surface_geometry_t) :: geometry
    real(rk) :: normals(mesh%n_dim, mesh%n_nodes)
    integer :: i, k

    where (rows%contact_entry == i_entry) leans = 0
    common = 0
    call measure_surface(mesh, groups(1), geometry)
    if (is_flat(geometry)) return
    call measure_surface(mesh, groups(2), geometry)
    associate (nodes => mesh%groups(groups(2))%nodes)
      normals(:, nodes) = averaged_normals(mesh, groups(2), geometry%area_vectors)
      do i = 1, size(nodes)
        associate (first => mesh%n_dim * (nodes(i) - 1) + 1)
          normals(:, nodes(i)) = normal_in_symmetry(normals(:, nodes(i)), is_prescribed(first:first + mesh%n_dim - 1))
        end associate
      end do
    end associate
    do k = 1, rows%n_rows
      if (rows%contact_entry(k) == i_entry) leans(k) = lean_of(normal_of_row(rows, k), facing_normal(rows, k, normals))
    end do
    k = minloc(leans, dim=1, mask=rows%contact_entry == i_entry)
    if (k == 0) return
    common = normal_of_row(rows, k)
    do k = 1, rows%n_rows
      if (rows%contact_entry(k) == i_entry) leans(k) = min(leans(k), lean_of(normal_of_row(rows, k), common))
    end do
  end subroutine measure_leans

  !> Returns the mean of the normals of the other surface at the nodes of a row on it, turned round, weighted by their shares in the
  !> row.
  pure function facing_normal(rows, k, normals) result(normal)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: k
    !> [-] outward normals of the other surface, shape (n_dim, n_nodes)
    real(rk), intent(in) :: normals(:, :)
    real(rk) :: normal(rows%n_dim)
    real(rk) :: own(rows%n_dim)
    integer, allocatable :: nodes(:)
    integer :: i

    own = normal_of_row(rows, k)
    nodes = rows%second_nodes_of(k)
    normal = 0
    do i = 1, size(nodes)
      associate (first => rows%splits(k) + rows%n_dim * (i - 1) + 1)
        normal = normal + dot_product(rows%coefficients(first:first + rows%n_dim - 1), own) * normals(:, nodes(i))
      end associate
    end do
  end function facing_normal

  !> [-] Returns tan(a)**2 of the angle between two vectors, at most that of least_cosine, also if one of them is 0.
  pure real(rk) function lean_of(a, b) result(lean)
    real(rk), intent(in) :: a(:), b(:)
    real(rk) :: cosine

    lean = 1 / least_cosine**2 - 1
    cosine = dot_product(a, b)
    if (cosine > least_cosine * norm2(a) * norm2(b)) lean = max(0.0_rk, (norm2(a) * norm2(b) / cosine)**2 - 1)
  end function lean_of

  !> [-] Returns the mean of tan(a)**2 over rows, weighted by their forces; 0 without forces.
  pure real(rk) function mean_lean(leans, forces) result(mean)
    real(rk), intent(in) :: leans(:)
    !> [force] >= 0, same shape
    real(rk), intent(in) :: forces(:)

    mean = 0
    if (any(forces > 0)) mean = dot_product(leans, forces / maxval(forces)) / sum(forces / maxval(forces))
  end function mean_lean
end module sig_leaning_rows
