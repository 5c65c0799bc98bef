! SPDX-License-Identifier: BSD-3-Clause
!> Writes the fields at several points for ParaView and the figures, of the full-order model or of a reduced model: fields.h5,
!> fields.xdmf, contact.h5 and contact.xdmf.
module sig_field_writer
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_surfaces, only: contact_surfaces_t, friction_states
  use sig_deck_config, only: output_config_t
  use sig_element_types, only: element_type_with
  use sig_errors, only: error_t
  use sig_field_file, only: field_file_t
  use sig_field_map, only: field_values_t, tensors_of
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_model, only: model_t
  use sig_parameter_space, only: format_point
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: field_writer_t

  !> Call create; then start_point and write_values for each point; then close. After write_values the caller may add further arrays
  !> of the point to file and surfaces. Local: one rank writes.
  type :: field_writer_t
    type(field_file_t) :: file
    type(contact_surfaces_t) :: surfaces
    type(output_config_t) :: wanted
  contains
    procedure :: create
    procedure :: start_point
    procedure :: write_values
    procedure :: write_friction
    procedure :: close => close_files
  end type field_writer_t

contains

  !> Starts the files and writes what is the same at all points. Without fields of contact, or without contact, there is no
  !> contact.h5, and that of an earlier run is removed with contact.xdmf. Errors: files cannot be created or removed.
  subroutine create(self, model, wanted, folder, error)
    class(field_writer_t), intent(inout) :: self
    !> its header and its field map are used, not its parts
    type(model_t), intent(in) :: model
    !> which fields
    type(output_config_t), intent(in) :: wanted
    !> where the files are written
    character(*), intent(in) :: folder
    type(error_t), allocatable, intent(out) :: error

    self%wanted = wanted
    call self%file%create(folder // '/fields.h5', mesh_of(model), model%length_unit, model%parameter_names, &
      model%parameter_units, error, model%i_time())
    if (allocated(error)) return
    call self%surfaces%create(model, wanted%has_contact, folder, error)
    if (allocated(error)) return
    call write_side(model%fields%rows, .false., 'contact/first', self%file)
    call write_side(model%fields%rows, .true., 'contact/second', self%file)
    call self%file%add_shared_array('contact/areas', model%areas(:model%laws%n_contacts), model%fields%area_unit, &
      'area of each contact row: pressure = multiplier / area')
    call self%file%add_shared_array('mesh/region_names', model%fields%region_names, '-', 'of 1, 2, ... in the field region')
  end subroutine create

  !> Returns the nodes and cells of the bodies as a mesh, without groups.
  pure type(mesh_t) function mesh_of(model) result(mesh)
    type(model_t), intent(in) :: model
    integer :: i

    mesh%n_dim = model%n_dim
    mesh%n_nodes = model%n_nodes
    mesh%n_cells = model%fields%n_cells()
    mesh%coordinates = model%coordinates
    mesh%cell_offsets = model%fields%of_cells%starts
    mesh%cell_nodes = model%fields%of_cells%nodes
    associate (offsets => mesh%cell_offsets)
      mesh%cell_types = [(element_type_with(model%n_dim, offsets(i + 1) - offsets(i)), i=1, mesh%n_cells)]
    end associate
  end function mesh_of

  !> Writes the lists of list_side for one side of all contact rows, which are the same at all points: starts (from 0), nodes
  !> (1-based) and weights.
  subroutine write_side(rows, is_second, group, file)
    type(contact_rows_t), intent(in) :: rows
    !> the second side, otherwise the first
    logical, intent(in) :: is_second
    !> path of the group in the file
    character(*), intent(in) :: group
    type(field_file_t), intent(inout) :: file
    integer, allocatable :: nodes(:), starts(:)
    real(rk), allocatable :: weights(:)

    call rows%list_side(is_second, starts, nodes, weights)
    call file%add_shared_array(group // '/starts', starts, '-', &
      'nodes of contact row k are entries starts(k) to starts(k + 1) - 1, all counted from 0; no entry: a rigid obstacle')
    call file%add_shared_array(group // '/nodes', nodes, '-', '1-based, order of the mesh file; the first one of a row on the ' // &
      'first surface carries its multiplier')
    call file%add_shared_array(group // '/weights', weights, '-', &
      'share of the row''s contact force on the node, negative where it pulls')
  end subroutine write_side

  !> Starts the fields of the next point, with its parameters as label.
  subroutine start_point(self, model, point)
    class(field_writer_t), intent(inout) :: self
    !> the model of create
    type(model_t), intent(in) :: model
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    character(:), allocatable :: label

    label = format_point(model%parameter_names, point, model%parameter_units)
    call self%file%start_point(label, point)
    call self%surfaces%start_point(label, point)
  end subroutine start_point

  !> Writes at the present point the fields that `wanted` of create names, and the region of each cell.
  subroutine write_values(self, model, values, is_reduced)
    class(field_writer_t), intent(inout) :: self
    !> the model of create
    type(model_t), intent(in) :: model
    type(field_values_t), intent(in) :: values
    !> the values are those of a reduced model, not full-order; only descriptions and the name of the array of multipliers differ
    logical, intent(in) :: is_reduced
    character(:), allocatable :: author

    author = merge('reduced model   ', 'full-order model', is_reduced)
    author = trim(author)
    if (self%wanted%has_displacement) call self%file%add_node_field('displacement', values%displacement, model%length_unit, &
      'displacement, ' // author)
    if (self%wanted%has_contact) then
      call write_contact(self, model, values, is_reduced, author)
      call self%surfaces%write_values(values, self%wanted%has_displacement)
    end if
    if (self%wanted%has_stress) call write_stresses(self, model, values, author)
    call self%file%add_cell_field('region', model%fields%regions, '-', 'of the mesh, 1-based, names in mesh/region_names; 0: none')
  end subroutine write_values

  subroutine write_contact(self, model, values, is_reduced, author)
    class(field_writer_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    type(field_values_t), intent(in) :: values
    logical, intent(in) :: is_reduced
    character(*), intent(in) :: author

    call self%file%add_node_field('contact_force', values%contact_force, model%force_unit, 'contact force on the node, ' // author)
    call self%file%add_node_field('contact_pressure', values%contact_pressure, model%fields%stress_unit, &
      'multiplier over area at nodes of the first surfaces, its mean by shares at those of the second')
    ! no field in viewers: it has no number off the contact surfaces, and contact.xdmf shows it on them
    call self%file%add_array('gap', values%gap, model%length_unit, &
      'open distance, the smallest of the rows at the node; no number off the contact surfaces')
    call self%file%add_cell_field('contact_status', values%cell_contact, '-', &
      '0 no contact row at its nodes, 1 open, 2 closed at all of them, 3 closed at some, 4 tied')
    call self%file%add_array(trim(merge('multipliers_reduced   ', 'multipliers_full_order', is_reduced)), values%multipliers, &
      model%force_unit, 'contact force of each row, ' // author)
    if (allocated(values%slips)) call self%write_friction(model, values, '')
    call write_areas(self, model, values)
  end subroutine write_contact

  !> Writes friction, slip and status of the nodes of both surfaces into fields.h5.
  subroutine write_friction(self, model, values, suffix)
    class(field_writer_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    type(field_values_t), intent(in) :: values
    !> behind the names of the fields
    character(*), intent(in) :: suffix

    call self%file%add_node_field('tangential_traction' // suffix, values%tangential_traction, model%fields%stress_unit, &
      'friction over area on the node''s own surface; at nodes without a row of their own its mean by shares')
    call self%file%add_node_field('slip' // suffix, values%slip, model%length_unit, &
      'of the node''s own surface over the other one since the last time')
    call self%file%add_node_field('friction_status' // suffix, real(values%node_friction, rk), '-', friction_states)
  end subroutine write_friction

  !> Writes for each contact of the deck the area that touches at the present point: of rows with a force, and of tied ones.
  subroutine write_areas(self, model, values)
    class(field_writer_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    type(field_values_t), intent(in) :: values
    real(rk) :: areas(model%resultants%n_entries())
    integer :: i

    call model%resultants%sum_areas(model%laws, model%areas, values%multipliers, areas)
    do i = 1, size(areas)
      call self%file%add_number('contact_' // to_text(i) // '_area', areas(i), model%fields%area_unit, &
        'area that touches: of the rows with a force, or tied; ' // model%resultants%names(i)%text)
    end do
  end subroutine write_areas

  !> Writes stresses and von Mises stresses, of cells and smoothed at nodes, and, if the deck has any, imposed strains of cells; in
  !> axisymmetry zz is the hoop direction.
  subroutine write_stresses(self, model, values, author)
    class(field_writer_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    type(field_values_t), intent(in) :: values
    !> `full-order model` or `reduced model`, for the descriptions
    character(*), intent(in) :: author

    associate (unit => model%fields%stress_unit)
      if (model%fields%has_imposed_strains()) call self%file%add_cell_field('imposed_strain', values%imposed_strain, '-', &
        'mean of what is imposed on the cell by temperature or swelling; stresses come from the rest of the strain')
      if (allocated(values%plastic)) call write_flow(self%file, values%plastic, values%plastic_smoothed, 'plastic')
      if (allocated(values%creep)) call write_flow(self%file, values%creep, values%creep_smoothed, 'creep')
      call self%file%add_cell_field('stress', values%stress, unit, 'mean stress of the cell, ' // author)
      call self%file%add_cell_field('von_mises', values%von_mises, unit, 'von Mises stress of the mean stress of the cell')
      call self%file%add_node_field('stress_smoothed', values%stress_smoothed, unit, &
        'mean stress of the cells around the node, weighted by volume, of one material')
      call self%file%add_node_field('von_mises_smoothed', values%von_mises_smoothed, unit, &
        'von Mises stress of the smoothed stress')
    end associate
  end subroutine write_stresses

  !> Writes plastic strains or creep strains: the equivalent strain of cells and smoothed at nodes, and the tensor of cells.
  subroutine write_flow(file, of_cells, of_nodes, kind)
    type(field_file_t), intent(inout) :: file
    !> as in field_values_t
    real(rk), intent(in) :: of_cells(:, :)
    real(rk), intent(in) :: of_nodes(:, :)
    !> `plastic` or `creep`
    character(*), intent(in) :: kind

    call file%add_cell_field(kind // '_strain', of_cells(7, :), '-', &
      'accumulated equivalent ' // kind // ' strain, mean of the cell')
    call file%add_cell_field(kind // '_strain_tensor', tensors_of(of_cells), '-', kind // ' strain, mean of the cell')
    call file%add_node_field(kind // '_strain_smoothed', of_nodes(7, :), '-', &
      'accumulated equivalent ' // kind // ' strain of the cells around the node, weighted by volume, of one material')
  end subroutine write_flow

  !> Closes the files and gives them their final names; after a failure in fields.h5, contact.h5 is not closed. Errors: the first
  !> failure since create.
  subroutine close_files(self, error)
    class(field_writer_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    call self%file%close(error)
    if (allocated(error)) return
    call self%surfaces%close(error)
  end subroutine close_files
end module sig_field_writer
