! SPDX-License-Identifier: BSD-3-Clause
!> Creates the field map: the data of a problem from which fields are computed, as a model keeps them.
module sig_field_mapping
  use sig_deck_units, only: area_unit, stress_unit
  use sig_errors, only: error_t
  use sig_field_map, only: field_map_t
  use sig_materials, only: add_material_terms
  use sig_mesh, only: nodes_of_facet
  use sig_mesh_checks, only: group_of_surface
  use sig_mesh_regions, only: region_names, regions_of_cells
  use sig_problem, only: problem_t, surface_of_side
  use sig_strain_maps, only: create_strain_maps
  implicit none(type, external)
  private
  public :: create_field_map

contains

  !> Creates the field map of the whole mesh. Local. Errors: a contact surface is not in the mesh, which cannot happen after the
  !> contact rows were built.
  subroutine create_field_map(problem, map, error)
    type(problem_t), intent(in) :: problem
    type(field_map_t), intent(out) :: map
    type(error_t), allocatable, intent(out) :: error

    map%mechanics = problem%body%mechanics
    map%stress_unit = stress_unit(problem%deck)
    map%area_unit = area_unit(problem%deck)
    map%region_names = region_names(problem%mesh)
    map%regions = regions_of_cells(problem%mesh)
    call map%set_rows(problem%force_rows, problem%laws%n_contacts)
    call create_strain_maps(problem%mesh, problem%body, problem%strains, map%of_cells, map%of_nodes)
    map%terms = problem%strains%terms
    call add_material_terms(problem%deck, map%terms, map%constant_terms)
    call list_facets(problem, map, error)
  end subroutine create_field_map

  !> Lists in the map the facets of the surface of each contact entry that carries the multipliers, with the entry (1-based) and the
  !> nodes of each facet. Errors: a surface is not in the mesh.
  subroutine list_facets(problem, map, error)
    type(problem_t), intent(in) :: problem
    type(field_map_t), intent(inout) :: map
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: facets(:)
    integer :: i, i_entry, i_group

    allocate (facets(0), map%facet_entries(0))
    do i_entry = 1, size(problem%deck%contact)
      call group_of_surface(problem%mesh, surface_of_side(problem, i_entry, 1), problem%deck%path, i_group, error)
      if (allocated(error)) return
      associate (found => problem%mesh%groups(i_group)%entities)
        facets = [facets, found]
        map%facet_entries = [map%facet_entries, spread(i_entry, 1, size(found))]
      end associate
    end do
    associate (offsets => problem%mesh%facet_offsets)
      allocate (map%facet_starts(size(facets) + 1), source=0)
      do i = 1, size(facets)
        map%facet_starts(i + 1) = map%facet_starts(i) + offsets(facets(i) + 1) - offsets(facets(i))
      end do
    end associate
    ! one facet after the other would copy a large surface again for each of its facets
    allocate (map%facet_nodes(map%facet_starts(size(facets) + 1)))
    do i = 1, size(facets)
      map%facet_nodes(map%facet_starts(i) + 1:map%facet_starts(i + 1)) = nodes_of_facet(problem%mesh, facets(i))
    end do
  end subroutine list_facets
end module sig_field_mapping
