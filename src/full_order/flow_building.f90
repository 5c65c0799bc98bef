! SPDX-License-Identifier: BSD-3-Clause
!> Makes the laws of the materials of a deck that flow, and what their properties need of the mesh.
module sig_flow_building
  use sig_deck_config, only: deck_config_t, material_config_t, value_config_t
  use sig_deck_material_laws, only: law_of_material, temperature_entries
  use sig_elastic_body, only: elastic_body_t
  use sig_element_types, only: element_types
  use sig_errors, only: error_t, make_error
  use sig_flow_model, only: flow_model_t
  use sig_flow_strains, only: can_flow
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: group_of_region
  use sig_nodal_field, only: nodal_field_t
  use sig_point_values, only: count_points
  use sig_strain_parts, only: point_product_t, value_products
  use sig_term_set, only: term_set_t
  use sig_text, only: append_text, string_t, to_text
  implicit none(type, external)
  private
  public :: add_temperatures, create_flow_model

contains

  !> Makes the laws, and tells the bodies which materials flow. Nothing flows without such a material. Errors: a cell whose type
  !> cannot flow.
  subroutine create_flow_model(mesh, deck, parameter_names, body, flow, error)
    type(mesh_t), intent(in) :: mesh
    type(deck_config_t), intent(in) :: deck
    type(string_t), intent(in) :: parameter_names(:)
    type(elastic_body_t), intent(inout) :: body
    type(flow_model_t), intent(inout) :: flow
    type(error_t), allocatable, intent(out) :: error
    type(value_config_t), allocatable :: values(:)
    logical :: flows(size(deck%materials))
    integer :: i, k

    flows = [(deck%materials(i)%flows(), i=1, size(flows))]
    if (.not. any(flows)) return
    allocate (flow%laws(size(flows)), flow%is_hot(size(flows)), flow%properties%starts(size(flows) + 1))
    allocate (flow%properties%names, source=parameter_names)
    call flow%properties%complete()
    flow%is_hot = .false.
    flow%properties%starts(1) = 0
    do i = 1, size(flows)
      if (flows(i)) then
        call law_of_material(deck%materials(i), flow%laws(i)%law, values)
        do k = 1, size(values)
          call append_text(flow%properties%texts, values(k)%text)
        end do
        flow%is_hot(i) = any(values%uses_temperature)
      end if
      flow%properties%starts(i + 1) = size(flow%properties%texts)
    end do
    flow%has_plasticity = any(deck%materials%plasticity%is_used)
    flow%has_creep = any(deck%materials%creep%is_used)
    call body%set_flow(flows)
    allocate (flow%temperatures(n_flowing_points(mesh, body), 0))
    call check_cells(mesh, deck, body, error)
  end subroutine create_flow_model

  !> Checks that all cells whose material flows have a type for it. Errors: the first that has not.
  subroutine check_cells(mesh, deck, body, error)
    type(mesh_t), intent(in) :: mesh
    type(deck_config_t), intent(in) :: deck
    type(elastic_body_t), intent(in) :: body
    type(error_t), allocatable, intent(out) :: error
    type(value_config_t) :: place
    character(8) :: name
    character(:), allocatable :: types, why
    integer :: i

    do i = 1, mesh%n_cells
      if (.not. body%flows_in(i)) cycle
      if (can_flow(mesh%cell_types(i))) cycle
      name = element_types(mesh%cell_types(i))%name
      why = 'has no rule of integration for that'
      if (name == 'T3' .or. name == 'T4') why = 'locks where the material keeps its volume'
      types = 'Q8, T6 or Q4'
      if (mesh%n_dim == 3) types = 'H20, T10, W15, H8 or W6'
      associate (material => deck%materials(body%material_of_cell(i)))
        place = place_of_flow(material)
        call make_error(error, 'materials.' // material%name // ' yields or creeps, but element ' // to_text(mesh%cell_tags(i)) // &
          ' of its regions is a ' // trim(name) // ', which ' // why // '; take ' // types, deck%path, place%line, place%column)
      end associate
      return
    end do
  end subroutine check_cells

  !> Returns the value of the deck at which a message about the flow of a material points.
  pure type(value_config_t) function place_of_flow(material) result(place)
    type(material_config_t), intent(in) :: material

    place = material%creep%coefficient
    if (material%plasticity%is_used) place = material%plasticity%yield_stress
  end function place_of_flow

  !> Adds the temperature at the points of all flowing cells, if some property contains it. Errors: an unknown region, or another
  !> one that group_of_region refuses; a temperature that is not finite at a point.
  subroutine add_temperatures(mesh, body, deck, fields, terms, flow, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(deck_config_t), intent(in) :: deck
    !> values of the files of imposed strains, shape (size(deck%imposed_strains))
    type(nodal_field_t), intent(in) :: fields(:)
    !> has the names that expressions may contain
    type(term_set_t), intent(in) :: terms
    type(flow_model_t), intent(inout) :: flow
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: entries(:)
    integer :: i_entry, i_material, i_region

    if (.not. flow%is_there()) return
    do i_material = 1, size(deck%materials)
      associate (regions => deck%materials(i_material)%regions)
        if (.not. flow%is_hot(i_material)) cycle
        do i_region = 1, size(regions)
          entries = temperature_entries(deck%imposed_strains, regions(i_region)%text)
          do i_entry = 1, size(entries)
            call add_entry(mesh, body, deck, entries(i_entry), i_material, fields(entries(i_entry)), terms, flow, error)
            if (allocated(error)) return
          end do
        end do
      end associate
    end do
  end subroutine add_temperatures

  !> Adds the temperature of one entry of imposed_strains in the cells of one material. Errors: as add_temperatures.
  subroutine add_entry(mesh, body, deck, i_entry, i_material, field, terms, flow, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(deck_config_t), intent(in) :: deck
    !> 1-based
    integer, intent(in) :: i_entry
    integer, intent(in) :: i_material
    type(nodal_field_t), intent(in) :: field
    type(term_set_t), intent(in) :: terms
    type(flow_model_t), intent(inout) :: flow
    type(error_t), allocatable, intent(out) :: error
    type(point_product_t), allocatable :: products(:)
    integer, allocatable :: cells(:), places(:)
    real(rk) :: values(size(flow%temperatures, 1))
    integer :: i, i_group

    associate (strain => deck%imposed_strains(i_entry))
      call group_of_region(mesh, strain%region, deck%path, i_group, error)
      if (allocated(error)) return
      associate (found => mesh%groups(i_group)%entities)
        cells = pack(found, body%material_of_cell(found) == i_material)
      end associate
      call value_products(mesh, body, strain, field, cells, terms, deck%path, products, error)
    end associate
    if (allocated(error)) return
    places = places_of_cells(mesh, body, cells)
    do i = 1, size(products)
      if (products(i)%of_parameters == '') products(i)%of_parameters = '1'
      call append_text(flow%properties%temperatures, products(i)%of_parameters)
      values = 0
      values(places) = products(i)%values
      flow%temperatures = reshape([flow%temperatures, values], [size(values), size(flow%temperatures, 2) + 1])
    end do
  end subroutine add_entry

  !> Returns the number of integration points of all cells that flow.
  pure integer function n_flowing_points(mesh, body) result(n)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    integer :: i

    n = count_points(mesh, body, pack([(i, i=1, mesh%n_cells)], [(body%flows_in(i), i=1, mesh%n_cells)]))
  end function n_flowing_points

  !> Returns the numbers of the points of some cells among those of all cells that flow.
  pure function places_of_cells(mesh, body, cells) result(places)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based; they flow
    integer, intent(in) :: cells(:)
    integer, allocatable :: places(:)
    integer :: first(mesh%n_cells), i, k, n

    n = 0
    do i = 1, mesh%n_cells
      first(i) = n
      if (body%flows_in(i)) n = n + count_points(mesh, body, [i])
    end do
    places = [(([(first(cells(i)) + k, k=1, count_points(mesh, body, [cells(i)]))]), i=1, size(cells))]
  end function places_of_cells
end module sig_flow_building
