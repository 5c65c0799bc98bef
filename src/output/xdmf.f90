! SPDX-License-Identifier: BSD-3-Clause
!> Makes the text of an XDMF 3 file: XML that tells ParaView and VTK what the arrays of an HDF5 file mean.
module sig_xdmf
  use sig_element_types, only: element_types, n_element_types
  use sig_kinds, only: rk
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: xdmf_mesh_t, xdmf_field_t, xdmf_number_t, xdmf_grid_t, xdmf_head, xdmf_grid, xdmf_tail

  !> The sizes of the arrays /mesh/coordinates and /mesh/topology.
  type :: xdmf_mesh_t
    integer :: n_nodes = 0
    integer :: n_cells = 0
    !> XDMF number of the type of all cells; 0 = cells of several types (mixed)
    integer :: cell_type = 0
    !> number of nodes of a cell if all cells have one type
    integer :: n_cell_nodes = 0
    !> size of /mesh/topology if it is mixed
    integer :: n_mixed_entries = 0
  end type xdmf_mesh_t

  !> One array of one parameter point.
  type :: xdmf_field_t
    character(:), allocatable :: name
    !> path in the HDF5 file
    character(:), allocatable :: address
    logical :: is_cell_field = .false.
    logical :: is_integer = .false.
    !> numbers per node or cell
    integer :: n_components = 1
  end type xdmf_field_t

  !> One number of one parameter point, which viewers show as field data.
  type :: xdmf_number_t
    character(:), allocatable :: name
    real(rk) :: value = 0
  end type xdmf_number_t

  !> The fields of one parameter point.
  type :: xdmf_grid_t
    character(:), allocatable :: label
    type(xdmf_field_t), allocatable :: fields(:)
    type(xdmf_number_t), allocatable :: numbers(:)
  end type xdmf_grid_t

  character(*), parameter :: nl = new_line('a')

contains

  !> Returns the text of an XDMF file before its grids. A file needs at least one grid. All grids form one temporal collection.
  pure function xdmf_head() result(text)
    character(:), allocatable :: text

    text = '<?xml version="1.0" encoding="utf-8"?>' // nl // '<Xdmf Version="3.0">' // nl // '  <Domain>' // nl // &
      '    <Grid Name="points" GridType="Collection" CollectionType="Temporal">' // nl
  end function xdmf_head

  !> Returns the text of an XDMF file after its grids.
  pure function xdmf_tail() result(text)
    character(:), allocatable :: text

    text = '    </Grid>' // nl // '  </Domain>' // nl // '</Xdmf>' // nl
  end function xdmf_tail

  !> Returns the text of topology and geometry, which are the same for each point.
  pure function mesh_text(h5_name, mesh) result(text)
    !> as for xdmf_grid, but already with XML's escapes
    character(*), intent(in) :: h5_name
    type(xdmf_mesh_t), intent(in) :: mesh
    character(:), allocatable :: text

    text = '        <Topology TopologyType="' // topology_name(mesh%cell_type) // '" NumberOfElements="' // &
      to_text(mesh%n_cells) // '"'
    ! a polyline does not say how many nodes it has
    if (mesh%cell_type == 1 .or. mesh%cell_type == 2) text = text // ' NodesPerElement="' // to_text(mesh%n_cell_nodes) // '"'
    text = text // '>' // nl
    if (mesh%cell_type == 0) then
      text = text // item_text(h5_name, '/mesh/topology', [mesh%n_mixed_entries], .true.)
    else
      text = text // item_text(h5_name, '/mesh/topology', [mesh%n_cells, mesh%n_cell_nodes], .true.)
    end if
    text = text // '        </Topology>' // nl // '        <Geometry GeometryType="XYZ">' // nl // &
      item_text(h5_name, '/mesh/coordinates', [mesh%n_nodes, 3], .false.) // '        </Geometry>' // nl
  end function mesh_text

  pure function topology_name(cell_type) result(name)
    integer, intent(in) :: cell_type
    character(:), allocatable :: name
    integer :: i

    name = 'Mixed'
    do i = 1, n_element_types
      if (element_types(i)%xdmf_type == cell_type) name = trim(element_types(i)%xdmf_name)
    end do
  end function topology_name

  !> Returns the text of the grid of one parameter point: mesh, fields, numbers.
  pure function xdmf_grid(h5_name, mesh, grid, time) result(text)
    !> name of the HDF5 file as seen from the folder of the XDMF file
    character(*), intent(in) :: h5_name
    type(xdmf_mesh_t), intent(in) :: mesh
    type(xdmf_grid_t), intent(in) :: grid
    !> time of the grid in viewers
    character(*), intent(in) :: time
    character(:), allocatable :: text
    integer :: i, n_values

    text = '      <Grid Name="' // escaped(grid%label) // '" GridType="Uniform">' // nl // &
      '        <Time Value="' // time // '"/>' // nl // mesh_text(escaped(h5_name), mesh)
    do i = 1, size(grid%fields)
      n_values = merge(mesh%n_cells, mesh%n_nodes, grid%fields(i)%is_cell_field)
      text = text // field_text(escaped(h5_name), grid%fields(i), n_values)
    end do
    do i = 1, size(grid%numbers)
      text = text // number_text(grid%numbers(i))
    end do
    text = text // '      </Grid>' // nl
  end function xdmf_grid

  pure function number_text(number) result(text)
    type(xdmf_number_t), intent(in) :: number
    character(:), allocatable :: text

    text = '        <Attribute Name="' // escaped(number%name) // '" AttributeType="Scalar" Center="Grid">' // nl // &
      '          <DataItem Dimensions="1" NumberType="Float" Precision="8" Format="XML">' // to_text(number%value) // &
      '</DataItem>' // nl // '        </Attribute>' // nl
  end function number_text

  pure function field_text(h5_name, field, n_values) result(text)
    character(*), intent(in) :: h5_name
    type(xdmf_field_t), intent(in) :: field
    !> number of nodes or of cells
    integer, intent(in) :: n_values
    character(:), allocatable :: text
    integer, allocatable :: sizes(:)

    sizes = [n_values, field%n_components]
    if (field%n_components == 1) sizes = [n_values]
    ! VTK 9.7 takes n x 6 for one matrix, ParaView 5.11 n x 6 x 1 for 6 n numbers; a row per value is clear to all
    if (value_name(field%n_components) == 'Matrix') sizes = [n_values, 1, field%n_components]
    text = '        <Attribute Name="' // escaped(field%name) // '" AttributeType="' // value_name(field%n_components) // &
      '" Center="' // trim(merge('Cell', 'Node', field%is_cell_field)) // '">' // nl // &
      item_text(h5_name, field%address, sizes, field%is_integer) // '        </Attribute>' // nl
  end function field_text

  !> Returns the attribute type of a field: Scalar (1), Vector (3), else Matrix. A symmetric tensor is written as a matrix of one
  !> row, because the readers of VTK read XDMF's type Tensor6 in different orders of the components. They keep the order of a
  !> matrix, and six components are xx, yy, zz, xy, yz, xz in VTK.
  pure function value_name(n_components) result(name)
    integer, intent(in) :: n_components
    character(:), allocatable :: name

    select case (n_components)
    case (1)
      name = 'Scalar'
    case (3)
      name = 'Vector'
    case default
      name = 'Matrix'
    end select
  end function value_name

  !> Returns the text of a reference to an array at a path (address) of the HDF5 file. The sizes are in the order of h5py,
  !> the one that changes slowest first.
  pure function item_text(h5_name, address, sizes, is_integer) result(text)
    !> as for xdmf_grid, but already with XML's escapes
    character(*), intent(in) :: h5_name
    character(*), intent(in) :: address
    integer, intent(in) :: sizes(:)
    logical, intent(in) :: is_integer
    character(:), allocatable :: text, dimensions
    integer :: i

    dimensions = ''
    do i = 1, size(sizes)
      if (i > 1) dimensions = dimensions // ' '
      dimensions = dimensions // to_text(sizes(i))
    end do
    text = '          <DataItem Dimensions="' // dimensions // '" NumberType="' // trim(merge('Int  ', 'Float', is_integer)) // &
      '" Precision="' // merge('4', '8', is_integer) // '" Format="HDF">' // h5_name // ':' // escaped(address) // &
      '</DataItem>' // nl
  end function item_text

  pure function escaped(text) result(xml)
    character(*), intent(in) :: text
    character(:), allocatable :: xml
    integer :: i

    xml = ''
    do i = 1, len(text)
      select case (text(i:i))
      case ('&')
        xml = xml // '&amp;'
      case ('<')
        xml = xml // '&lt;'
      case ('>')
        xml = xml // '&gt;'
      case ('"')
        xml = xml // '&quot;'
      case default
        xml = xml // text(i:i)
      end select
    end do
  end function escaped
end module sig_xdmf
