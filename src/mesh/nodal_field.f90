! SPDX-License-Identifier: BSD-3-Clause
!> Reads a field with one value per node from a file that identifies nodes by their numbers in the mesh file.
module sig_nodal_field
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
  use sig_deck_config, only: field_config_t, imposed_strain_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: group_of_region
  use sig_nodal_field_file, only: raw_field_t, read_raw_field
  use sig_sorting, only: sort_by_keys
  use sig_text, only: join, to_text
  implicit none(type, external)
  private
  public :: nodal_field_t, read_nodal_field

  !> The values of a field at the nodes of the mesh.
  type :: nodal_field_t
    !> NaN at nodes without a value in the file, shape (n_nodes)
    real(rk), allocatable :: values(:)
  end type nodal_field_t

  !> [-] largest difference of coordinates that counts as rounding in files, relative to the largest coordinate
  real(rk), parameter :: same_place = 1.0e-6_rk

contains

  !> Reads the field of an imposed strain, which must have a finite value at every node of the strain's region; the values at other
  !> nodes are not checked. If the file has several values of a node, the first one counts. Requires: strain%has_field. Local.
  !>
  !> Errors: a region that group_of_region refuses; those of read_raw_field; a value at a node that the mesh does not have; if the
  !> file has coordinates, a wrong shape of them or a node at another place than in the mesh; a node of the region without a finite
  !> value.
  subroutine read_nodal_field(mesh, strain, deck_path, field, error, length_factor)
    type(mesh_t), intent(in) :: mesh
    !> entry of the deck that names region, file and field
    type(imposed_strain_config_t), intent(in) :: strain
    !> name of the deck for messages
    character(*), intent(in) :: deck_path
    !> NaN at nodes without a value in the file
    type(nodal_field_t), intent(out) :: field
    type(error_t), allocatable, intent(out) :: error
    !> factor for the coordinates of the file [units.length / mesh.length_unit], default 1
    real(rk), intent(in), optional :: length_factor
    type(raw_field_t) :: raw
    integer :: i_group

    call group_of_region(mesh, strain%region, deck_path, i_group, error)
    if (allocated(error)) return
    call read_raw_field(strain%field, deck_path, raw, error)
    if (allocated(error)) return
    if (present(length_factor) .and. allocated(raw%coordinates)) raw%coordinates = length_factor * raw%coordinates
    call place_values(mesh, raw, strain%field, deck_path, field%values, error)
    if (allocated(error)) return
    call check_places(mesh, raw, strain%field, deck_path, error)
    if (allocated(error)) return
    call check_region(mesh, i_group, raw, field%values, strain%field, deck_path, error)
  end subroutine read_nodal_field

  !> Assigns the values of the file to the nodes of the mesh, the first one if a node has several. Errors: a value at a node that
  !> the mesh does not have.
  subroutine place_values(mesh, raw, config, deck_path, values, error)
    type(mesh_t), intent(in) :: mesh
    type(raw_field_t), intent(in) :: raw
    type(field_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    !> NaN at nodes without a value in the file, shape (n_nodes)
    real(rk), allocatable, intent(out) :: values(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i, i_node, n_unknown, order(mesh%n_nodes)

    order = order_of(mesh%node_tags)
    allocate (values(mesh%n_nodes), source=ieee_value(1.0_rk, ieee_quiet_nan))
    n_unknown = 0
    do i = size(raw%tags), 1, -1
      i_node = node_with_tag(mesh%node_tags, order, raw%tags(i))
      if (i_node > 0) then
        values(i_node) = raw%values(i)
      else
        n_unknown = i
      end if
    end do
    if (n_unknown > 0) call make_error(error, 'the field ''' // config%name%text // ''' has a value at node ' // &
      to_text(raw%tags(n_unknown)) // ', which no cell of a named region has: does the field belong to another mesh? (' // &
      to_text(size(raw%tags)) // ' nodes have values; the mesh has ' // to_text(mesh%n_nodes) // ')', deck_path, config%name%line, &
      config%name%column)
  end subroutine place_values

  !> Checks that the nodes of the file, if it has coordinates, are at the same places as in the mesh, because another mesh may have
  !> the same node numbers. Nodes that the mesh lacks do not count, nor do components beyond n_dim. Errors: the number of places is
  !> not that of node numbers, or a place has fewer than n_dim components; a coordinate differs from the mesh's by more than 1e-6 of
  !> the mesh's largest coordinate in size.
  subroutine check_places(mesh, raw, config, deck_path, error)
    type(mesh_t), intent(in) :: mesh
    type(raw_field_t), intent(in) :: raw
    type(field_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    type(error_t), allocatable, intent(out) :: error
    integer :: i, i_node, order(mesh%n_nodes)
    real(rk) :: allowed

    if (.not. allocated(raw%coordinates)) return
    if (size(raw%coordinates, 2) /= size(raw%place_tags) .or. size(raw%coordinates, 1) < mesh%n_dim) then
      call make_error(error, 'the coordinates in the field file ''' // config%file // ''' are ' // &
        to_text(size(raw%coordinates, 2)) // ' rows of ' // to_text(size(raw%coordinates, 1)) // ' numbers; there must be ' // &
        to_text(size(raw%place_tags)) // ' rows of ' // to_text(mesh%n_dim) // ' or more', deck_path, config%name%line, &
        config%name%column)
      return
    end if
    order = order_of(mesh%node_tags)
    allowed = same_place * maxval([0.0_rk, abs(mesh%coordinates)])
    do i = 1, size(raw%place_tags)
      i_node = node_with_tag(mesh%node_tags, order, raw%place_tags(i))
      ! no cell of a named region has this node, so the mesh does not have it
      if (i_node == 0) cycle
      if (all(abs(mesh%coordinates(:, i_node) - raw%coordinates(:mesh%n_dim, i)) <= allowed)) cycle
      call make_error(error, 'the field ''' // config%name%text // ''' belongs to another mesh: node ' // &
        to_text(raw%place_tags(i)) // ' lies at ' // place_text(raw%coordinates(:mesh%n_dim, i)) // ' in its file, and at ' // &
        place_text(mesh%coordinates(:, i_node)) // ' in the mesh', deck_path, config%name%line, config%name%column)
      return
    end do
  end subroutine check_places

  pure function place_text(place) result(text)
    real(rk), intent(in) :: place(:)
    character(:), allocatable :: text

    text = '(' // join(place, ', ') // ')'
  end function place_text

  subroutine check_region(mesh, i_group, raw, values, config, deck_path, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_group
    type(raw_field_t), intent(in) :: raw
    real(rk), intent(in) :: values(:)
    type(field_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: message
    integer :: i_bad

    associate (nodes => mesh%groups(i_group)%nodes)
      i_bad = findloc(ieee_is_finite(values(nodes)), .false., dim=1)
      if (i_bad == 0) return
      associate (tag => mesh%node_tags(nodes(i_bad)))
        message = 'has no value at node '
        if (any(raw%tags == tag)) message = 'is not finite at node '
        call make_error(error, 'the field ''' // config%name%text // ''' ' // message // to_text(tag) // ' of the region ''' // &
          mesh%groups(i_group)%name // ''' (' // to_text(size(raw%tags)) // ' nodes have values; the region has ' // &
          to_text(size(nodes)) // ')', deck_path, config%name%line, config%name%column)
      end associate
    end associate
  end subroutine check_region

  !> Returns the order in which the tags ascend: then tags(order) ascends, and equal tags keep their order.
  pure function order_of(tags) result(order)
    integer, intent(in) :: tags(:)
    integer :: order(size(tags))
    integer :: i

    order = [(i, i=1, size(tags))]
    call sort_by_keys(reshape(real(tags, rk), [1, size(tags)]), order)
  end function order_of

  !> Returns the node (1-based) with a tag; 0 if there is none.
  pure integer function node_with_tag(tags, order, tag) result(i_node)
    !> tag of each node, and their order (order_of), both shape (n_nodes); not empty
    integer, intent(in) :: tags(:)
    integer, intent(in) :: order(:)
    integer, intent(in) :: tag
    integer :: first, last, middle

    first = 1
    last = size(order)
    do while (first < last)
      middle = (first + last) / 2
      if (tags(order(middle)) < tag) then
        first = middle + 1
      else
        last = middle
      end if
    end do
    i_node = order(first)
    if (tags(i_node) /= tag) i_node = 0
  end function node_with_tag
end module sig_nodal_field
