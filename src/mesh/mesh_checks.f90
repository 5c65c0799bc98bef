! SPDX-License-Identifier: BSD-3-Clause
!> Finds the groups of the mesh that the deck names: regions, boundaries, surfaces.
module sig_mesh_checks
  use sig_deck_config, only: material_config_t, name_config_t, zone_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: group_t, mesh_t
  use sig_rounding, only: rounding_of_data
  use sig_text, only: append_text, did_you_mean, join, string_t, to_text
  implicit none(type, external)
  private
  public :: material_of_cells, nodes_of_boundary, nodes_of_zone, group_of_region, group_of_surface

contains

  !> Finds the material of each cell. Errors: a region that group_of_region refuses, a cell with two materials, a cell without one.
  !> Then material_of_cell is not complete.
  pure subroutine material_of_cells(mesh, materials, deck_path, material_of_cell, error)
    type(mesh_t), intent(in) :: mesh
    !> section materials of the deck
    type(material_config_t), intent(in) :: materials(:)
    !> for messages
    character(*), intent(in) :: deck_path
    !> index in `materials`, 1-based, shape (n_cells)
    integer, allocatable, intent(out) :: material_of_cell(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i_material, i_region

    allocate (material_of_cell(mesh%n_cells), source=0)
    do i_material = 1, size(materials)
      do i_region = 1, size(materials(i_material)%regions)
        call fill_region(mesh, materials, i_material, materials(i_material)%regions(i_region), deck_path, material_of_cell, error)
        if (allocated(error)) return
      end do
    end do
    if (any(material_of_cell == 0)) call refuse_bare_cell(mesh, findloc(material_of_cell, 0, dim=1), materials, deck_path, error)
  end subroutine material_of_cells

  pure subroutine fill_region(mesh, materials, i_material, region, deck_path, material_of_cell, error)
    type(mesh_t), intent(in) :: mesh
    type(material_config_t), intent(in) :: materials(:)
    integer, intent(in) :: i_material
    type(name_config_t), intent(in) :: region
    character(*), intent(in) :: deck_path
    integer, intent(inout) :: material_of_cell(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i, i_cell, i_group

    call find_name(mesh, region, mesh%n_dim, mesh%n_dim, 'region', deck_path, i_group, error)
    if (allocated(error)) return
    do i = 1, size(mesh%groups(i_group)%entities)
      i_cell = mesh%groups(i_group)%entities(i)
      if (material_of_cell(i_cell) /= 0 .and. material_of_cell(i_cell) /= i_material) then
        call make_error(error, "region '" // region%text // "' of material '" // materials(i_material)%name // &
                        "' holds cells that have material '" // materials(material_of_cell(i_cell))%name // "' already", &
                        file=deck_path, line=region%line, column=region%column)
        return
      end if
      material_of_cell(i_cell) = i_material
    end do
  end subroutine fill_region

  pure subroutine refuse_bare_cell(mesh, i_cell, materials, deck_path, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_cell
    type(material_config_t), intent(in) :: materials(:)
    character(*), intent(in) :: deck_path
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: names(:)
    integer :: i_group, line, column

    allocate (names(0))
    do i_group = 1, size(mesh%groups)
      if (mesh%groups(i_group)%n_dim /= mesh%n_dim) cycle
      if (any(mesh%groups(i_group)%entities == i_cell)) call append_text(names, "'" // mesh%groups(i_group)%name // "'")
    end do
    line = 0
    column = 0
    if (size(materials) > 0) then
      line = materials(1)%regions(1)%line
      column = materials(1)%regions(1)%column
    end if
    call make_error(error, 'a cell of the mesh has no material: element ' // to_text(mesh%cell_tags(i_cell)) // &
                    ', in the region ' // join(names, ' and in '), file=deck_path, line=line, column=column, &
                    hint='add one of its regions to the regions of a material; other cells may lack one, too')
  end subroutine refuse_bare_cell

  !> Finds the nodes of a named boundary, ascending. This is a group of facets, edges or points; a region of the same name does not
  !> count.
  !>
  !> Errors: unknown name, the name of a region only, a name of several such groups, a group without nodes, an element of the
  !> group with a node that belongs to no cell of a named region. The error has the name's place in the deck; then `nodes` is not
  !> allocated.
  pure subroutine nodes_of_boundary(mesh, boundary, deck_path, nodes, error)
    type(mesh_t), intent(in) :: mesh
    type(name_config_t), intent(in) :: boundary
    !> for messages
    character(*), intent(in) :: deck_path
    !> 1-based
    integer, allocatable, intent(out) :: nodes(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i_group

    call find_name(mesh, boundary, 0, mesh%n_dim - 1, 'boundary', deck_path, i_group, error)
    if (allocated(error)) return
    nodes = mesh%groups(i_group)%nodes
  end subroutine nodes_of_boundary

  !> Finds the nodes of a zone of interest, ascending: those of its boundary that lie in its window, or all without a window.
  !> Errors: as nodes_of_boundary, and a window without nodes. Then `nodes` is not allocated or empty.
  pure subroutine nodes_of_zone(mesh, zone, deck_path, nodes, error)
    type(mesh_t), intent(in) :: mesh
    type(zone_config_t), intent(in) :: zone
    character(*), intent(in) :: deck_path
    !> 1-based
    integer, allocatable, intent(out) :: nodes(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: all_nodes(:)
    logical, allocatable :: is_inside(:)
    real(rk) :: margin

    call nodes_of_boundary(mesh, zone%boundary, deck_path, all_nodes, error)
    if (allocated(error)) return
    nodes = all_nodes
    if (zone%axis == 0) return
    associate (place => mesh%coordinates(zone%axis, all_nodes))
      margin = rounding_of_data * (maxval(mesh%coordinates(zone%axis, :)) - minval(mesh%coordinates(zone%axis, :)))
      allocate (is_inside(size(place)), source=.true.)
      if (zone%has_minimum) is_inside = place >= zone%minimum - margin
      if (zone%has_maximum) is_inside = is_inside .and. place <= zone%maximum + margin
    end associate
    nodes = pack(all_nodes, is_inside)
    if (size(nodes) == 0) call make_error(error, 'no node of ''' // zone%boundary%text // ''' lies in the window of ' // &
      'this entry of reduction.zones_of_interest', deck_path, zone%boundary%line, zone%boundary%column, &
      hint='correct axis, min or max of the window (in units.length), or leave the window out')
  end subroutine nodes_of_zone

  !> Finds the index in mesh%groups of a named surface, a group of facets; 0 on an error. Errors: as nodes_of_boundary, but only
  !> groups of facets count.
  pure subroutine group_of_surface(mesh, surface, deck_path, i_group, error)
    type(mesh_t), intent(in) :: mesh
    type(name_config_t), intent(in) :: surface
    character(*), intent(in) :: deck_path
    integer, intent(out) :: i_group
    type(error_t), allocatable, intent(out) :: error

    call find_name(mesh, surface, mesh%n_dim - 1, mesh%n_dim - 1, 'surface', deck_path, i_group, error)
  end subroutine group_of_surface

  !> Finds the index in mesh%groups of a named region, a group of cells; 0 on an error. Errors: no such region, several of this
  !> name, or a region without cells.
  pure subroutine group_of_region(mesh, region, deck_path, i_group, error)
    type(mesh_t), intent(in) :: mesh
    type(name_config_t), intent(in) :: region
    character(*), intent(in) :: deck_path
    integer, intent(out) :: i_group
    type(error_t), allocatable, intent(out) :: error

    call find_name(mesh, region, mesh%n_dim, mesh%n_dim, 'region', deck_path, i_group, error)
  end subroutine group_of_region

  !> Finds the group with a name and a dimension from min_dim to max_dim. If there are several, as where the rim of a surface has
  !> its name, it is the one that has all nodes of the others. Errors: as nodes_of_boundary, for groups of these dimensions.
  pure subroutine find_name(mesh, name, min_dim, max_dim, noun, deck_path, i_group, error)
    type(mesh_t), intent(in) :: mesh
    type(name_config_t), intent(in) :: name
    integer, intent(in) :: min_dim, max_dim
    !> word for messages: region, boundary or surface
    character(*), intent(in) :: noun
    character(*), intent(in) :: deck_path
    !> index of the group; 0 on an error
    integer, intent(out) :: i_group
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: to_join = 'in the .geo file, name the region beside it; where their nodes differ, join both ' // &
      'by Coherence'
    character(:), allocatable :: hint
    integer, allocatable :: found(:)
    integer :: i

    i_group = 0
    allocate (found(0))
    do i = 1, size(mesh%groups)
      if (mesh%groups(i)%name /= name%text .or. len(mesh%groups(i)%name) /= len(name%text)) cycle
      if (mesh%groups(i)%n_dim >= min_dim .and. mesh%groups(i)%n_dim <= max_dim) found = [found, i]
    end do
    if (size(found) > 0) i_group = found(maxloc(mesh%groups(found)%n_dim, dim=1))
    if (size(found) == 0) then
      call refuse_unknown_name(mesh, name, min_dim, max_dim, noun, deck_path, error)
    else if (.not. all([(has_nodes_of(mesh%groups(i_group), mesh%groups(found(i))), i=1, size(found))])) then
      call make_error(error, "the mesh has " // to_text(size(found)) // " physical groups with the name '" // name%text // &
                      "' that could be this " // noun // ', and none has all nodes of the others', file=deck_path, &
                      line=name%line, column=name%column, hint='give each its own name in the .geo file')
    else if (size(mesh%groups(i_group)%nodes) == 0) then
      hint = 'see that the mesh has elements of this group'
      if (noun /= 'region') hint = hint // '; ' // to_join
      call make_error(error, "the " // noun // " '" // name%text // "' of the mesh has no element whose nodes all belong to " // &
                      'cells of named regions', file=deck_path, line=name%line, column=name%column, hint=hint)
    else if (mesh%groups(i_group)%n_left_out > 0) then
      call make_error(error, 'elements of the ' // noun // " '" // name%text // "' with a node that no cell of a named region " // &
                      'has: ' // to_text(mesh%groups(i_group)%n_left_out), file=deck_path, line=name%line, column=name%column, &
                      hint=to_join)
    end if
    if (allocated(error)) i_group = 0
  end subroutine find_name

  !> Whether a group has all nodes of another one.
  pure logical function has_nodes_of(group, other)
    type(group_t), intent(in) :: group, other
    logical :: is_in(max(maxval([0, group%nodes]), maxval([0, other%nodes])))

    is_in = .false.
    is_in(group%nodes) = .true.
    has_nodes_of = all(is_in(other%nodes))
  end function has_nodes_of

  pure subroutine refuse_unknown_name(mesh, name, min_dim, max_dim, noun, deck_path, error)
    type(mesh_t), intent(in) :: mesh
    type(name_config_t), intent(in) :: name
    integer, intent(in) :: min_dim, max_dim
    character(*), intent(in) :: noun, deck_path
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: candidates(:)
    character(:), allocatable :: message, guess, owner
    integer :: i

    message = "the mesh has no " // noun // " '" // name%text // "'"
    owner = 'it'
    allocate (candidates(0))
    do i = 1, size(mesh%groups)
      if (mesh%groups(i)%n_dim >= min_dim .and. mesh%groups(i)%n_dim <= max_dim) then
        call append_text(candidates, mesh%groups(i)%name)
      else if (mesh%groups(i)%name == name%text) then
        message = "'" // name%text // "' of the mesh is no " // noun // ' but ' // kind_of_group(mesh, i)
        owner = 'the mesh'
      end if
    end do
    if (size(candidates) > 0) message = message // '; ' // owner // ' has ' // join(candidates, ', ')
    if (size(candidates) == 0) message = message // '; ' // owner // ' has none'
    guess = did_you_mean(name%text, candidates)
    if (len(guess) > 0) guess = "did you mean '" // guess // "'?"
    call make_error(error, message, file=deck_path, line=name%line, column=name%column, hint=guess)
  end subroutine refuse_unknown_name

  pure function kind_of_group(mesh, i_group) result(text)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_group
    character(:), allocatable :: text

    if (mesh%groups(i_group)%n_dim == mesh%n_dim) then
      text = 'a region of cells'
    else if (mesh%groups(i_group)%n_dim == mesh%n_dim - 1) then
      text = 'a surface'
    else
      text = 'a group of dimension ' // to_text(mesh%groups(i_group)%n_dim)
    end if
  end function kind_of_group
end module sig_mesh_checks
