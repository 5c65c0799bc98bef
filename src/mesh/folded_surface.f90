! SPDX-License-Identifier: BSD-3-Clause
!> Refuses a contact surface that is folded onto itself, because one name was given to both sides of an interface.
module sig_folded_surface
  use sig_deck_config, only: name_config_t
  use sig_errors, only: error_t
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_surface_geometry, only: averaged_normals, surface_geometry_t
  use sig_surface_pair, only: node_text, refuse, surface_pair_t
  implicit none(type, external)
  private
  public :: check_folded

  !> [-] share of the mesh size: between nodes that are closer than this there is no other body, not even a foil
  real(rk), parameter :: near = 1.0e-3_rk
  !> [-] normals whose cosine is not above this count as opposite, also on curved facets and at rims
  real(rk), parameter :: opposite = -0.5_rk
  !> [-] rounding of coordinates, relative to the mesh size
  real(rk), parameter :: rounding = 1.0e-6_rk

contains

  !> Checks one surface. Errors: two nodes of the surface are at most 1e-3 of geometry%mesh_size apart, have opposite averaged
  !> normals (at least 120 degrees between them), and are not behind each other. The nodes on both sides of a thin plate are behind
  !> each other, and are no error. Nothing is checked if any node of the surface has no averaged normal.
  pure subroutine check_folded(mesh, surfaces, surface, i_group, geometry, error)
    type(mesh_t), intent(in) :: mesh
    !> contact entry, for messages
    type(surface_pair_t), intent(in) :: surfaces
    !> name of the surface in the deck
    type(name_config_t), intent(in) :: surface
    !> group of the surface in the mesh
    integer, intent(in) :: i_group
    !> of measure_surface, without an inner facet
    type(surface_geometry_t), intent(in) :: geometry
    type(error_t), allocatable, intent(out) :: error
    type(k_d_tree_t) :: tree
    integer, allocatable :: others(:)
    real(rk) :: way(mesh%n_dim)
    integer :: i, k

    associate (nodes => mesh%groups(i_group)%nodes, normals => averaged_normals(mesh, i_group, geometry%area_vectors), &
      size_of_edge => geometry%mesh_size)
      ! another check reports nodes without a normal
      if (any(.not. norm2(normals, dim=1) > 0)) return
      call tree%create(mesh%coordinates(:, nodes))
      do i = 1, size(nodes)
        call tree%within(mesh%coordinates(:, nodes(i)), near * size_of_edge, others)
        do k = 1, size(others)
          way = mesh%coordinates(:, nodes(others(k))) - mesh%coordinates(:, nodes(i))
          if (dot_product(normals(:, i), normals(:, others(k))) > opposite) cycle
          if (dot_product(way, normals(:, i)) < -rounding * size_of_edge) cycle
          call refuse(surfaces, surface, "the surface '" // surface%text // "' is folded onto itself: " // &
                      node_text(mesh, nodes(i)) // ' and ' // node_text(mesh, nodes(others(k))) // &
                      ' have opposite normals and are not behind each other', error, &
                      'give each side its own name in the .geo file: one is the first surface, the other the second')
          return
        end do
      end do
    end associate
  end subroutine check_folded
end module sig_folded_surface
