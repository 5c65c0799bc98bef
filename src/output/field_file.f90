! SPDX-License-Identifier: BSD-3-Clause
!> Writes fields on a mesh for several parameter points: an HDF5 file with the arrays, and an XDMF file beside it for ParaView.
module sig_field_file
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_field_topology, only: write_topology
  use sig_file_system, only: base_name, write_text_file
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_text, only: short_number, string_t, to_text
  use sig_text_buffer, only: text_buffer_t
  use sig_version, only: code_version
  use sig_xdmf, only: xdmf_field_t, xdmf_grid, xdmf_grid_t, xdmf_head, xdmf_mesh_t, xdmf_number_t, xdmf_tail
  implicit none(type, external)
  private
  public :: field_file_t

  !> version 3: contact rows may have several nodes on each side; 2: symmetric tensors in VTK's order; 1: xx, xy, xz, yy, yz, zz
  integer, parameter :: format_version = 3

  !> Call create; then for each point start_point and the add procedures; then close. Both files appear with close.
  !>
  !> Vector fields of 1 to 3 components get zeros up to the third, so that viewers can warp by them; scalar fields get none. Fields
  !> of 4 or 6 components are symmetric tensors in VTK's order xx, yy, zz, xy, yz, xz (attribute `components`); with 4, yz and xz
  !> are zero. Arrays that are no fields of the mesh (`add_array`, `add_shared_array`) stand in the HDF5 file only. Numbers of a
  !> point and its parameters are field data in viewers, where their names end with the unit, if there is one. The first failure is
  !> kept until close returns it. h5py shows the shapes reversed, see sig_hdf5_writer. Local: one rank writes.
  type :: field_file_t
    private
    type(h5_writer_t) :: file
    character(:), allocatable :: path
    type(xdmf_mesh_t) :: mesh
    !> fields of the present point, number of points so far, and text of the XDMF file before this point
    type(xdmf_grid_t) :: grid
    integer :: n_points = 0
    type(text_buffer_t) :: xdmf
    !> group of the present point: `/points/0001`
    character(:), allocatable :: group
    type(string_t), allocatable :: parameter_names(:)
    type(string_t), allocatable :: parameter_units(:)
    integer :: i_time = 0
    !> times of viewers: of the last point, and where the times of the present history begin
    real(rk) :: time = 0
    real(rk) :: time_offset = 0
    type(error_t), allocatable :: error
  contains
    procedure :: create
    procedure :: start_point
    generic :: add_node_field => add_node_scalar, add_node_vector
    generic :: add_cell_field => add_cell_scalar, add_cell_integer, add_cell_vector
    procedure :: add_number
    generic :: add_array => add_real_array, add_real_matrix, add_integer_array
    generic :: add_shared_array => add_shared_reals, add_shared_matrix, add_shared_integers, add_shared_texts
    procedure :: close => close_file
    procedure, private :: add_node_scalar, add_node_vector, add_cell_scalar, add_cell_integer, add_cell_vector
    procedure, private :: add_real_array, add_real_matrix, add_integer_array
    procedure, private :: add_shared_reals, add_shared_matrix, add_shared_integers, add_shared_texts
  end type field_file_t

contains

  !> Starts the files, which get their names at close, and writes the mesh. Errors: the HDF5 file cannot be created.
  subroutine create(self, path, mesh, length_unit, parameter_names, parameter_units, error, i_time)
    class(field_file_t), intent(inout) :: self
    !> path of the HDF5 file, which ends with .h5; the XDMF file beside it ends with .xdmf
    character(*), intent(in) :: path
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: length_unit
    type(string_t), intent(in) :: parameter_names(:)
    !> units in the order of the names
    type(string_t), intent(in) :: parameter_units(:)
    type(error_t), allocatable, intent(out) :: error
    !> number of the parameter that is the time of viewers; 0 (default): the number of the point is their time
    integer, intent(in), optional :: i_time

    self%path = path
    self%group = ''
    self%parameter_names = parameter_names
    self%parameter_units = parameter_units
    if (allocated(self%error)) deallocate (self%error)
    self%n_points = 0
    self%i_time = 0
    if (present(i_time)) self%i_time = i_time
    self%time = 0
    self%time_offset = 0
    call start_grid(self, 'mesh')
    call self%xdmf%clear()
    call self%xdmf%add(xdmf_head())
    call self%file%create(path, error)
    if (allocated(error)) return
    call self%file%write('/@format', 'signorom fields')
    call self%file%write('/@code_version', code_version)
    call self%file%write('/@format_version', format_version)
    call self%file%write('/mesh/coordinates', padded(mesh%coordinates, 3), length_unit, 'x, y, z of the nodes')
    call write_topology(mesh, self%file, self%mesh)
  end subroutine create

  !> Starts the next parameter point: all that the add procedures write from here on, except for add_shared_array, belongs to it. A
  !> file without points has one grid; its arrays stand at the root of the HDF5 file. Attributes of a point: label, parameters.
  subroutine start_point(self, label, parameters)
    class(field_file_t), intent(inout) :: self
    !> name of the point in ParaView, e.g. `squeeze = 0.2`
    character(*), intent(in) :: label
    !> values in the order of the names given to create, and in their units
    real(rk), intent(in) :: parameters(:)
    character(16) :: number
    integer :: i

    if (self%n_points > 0) call end_grid(self)
    self%n_points = self%n_points + 1
    call set_time(self, parameters)
    write (number, '(i0.4)') self%n_points
    self%group = '/points/' // trim(number)
    call start_grid(self, label)
    call self%file%write(self%group // '@label', label)
    call self%file%write(self%group // '@parameter_names', self%parameter_names)
    call self%file%write(self%group // '@parameter_units', self%parameter_units)
    call self%file%write(self%group // '@parameters', parameters)
    do i = 1, size(parameters)
      call note_number(self, self%parameter_names(i)%text, parameters(i), self%parameter_units(i)%text)
    end do
  end subroutine start_point

  !> Returns the time of viewers of the present point as text; `1` for a file without points.
  pure function time_text(self) result(text)
    class(field_file_t), intent(in) :: self
    character(:), allocatable :: text

    text = to_text(max(1, self%n_points))
    if (self%i_time > 0 .and. self%n_points > 0) text = short_number(self%time, 15)
  end function time_text

  !> Sets the time of viewers for the next point to the value of the parameter i_time. Where this value does not grow, the next
  !> history begins: its times follow those before, because viewers need times that ascend.
  subroutine set_time(self, parameters)
    class(field_file_t), intent(inout) :: self
    real(rk), intent(in) :: parameters(:)

    if (self%i_time == 0) return
    if (self%time_offset + parameters(self%i_time) <= self%time) self%time_offset = self%time
    self%time = self%time_offset + parameters(self%i_time)
  end subroutine set_time

  !> Starts the description of a grid, which has no fields and numbers yet. Writes nothing.
  subroutine start_grid(self, label)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: label

    if (allocated(self%grid%fields)) deallocate (self%grid%fields, self%grid%numbers)
    self%grid%label = label
    allocate (self%grid%fields(0), self%grid%numbers(0))
  end subroutine start_grid

  !> Appends the grid of the present point, or the one of a file without points, to the text of the XDMF file.
  subroutine end_grid(self)
    class(field_file_t), intent(inout) :: self

    call self%xdmf%add(xdmf_grid(self%path(index(self%path, '/', back=.true.) + 1:), self%mesh, self%grid, time_text(self)))
  end subroutine end_grid

  !> Adds a number of the present point, e.g. a resultant: a scalar in the HDF5 file and field data for viewers.
  subroutine add_number(self, name, value, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write(self%group // '/' // name, value, unit, description)
    call note_number(self, name, value, unit)
  end subroutine add_number

  !> Lists a number of the point for the XDMF file, under `name [unit]`, or only its name if the unit is empty or `-`.
  subroutine note_number(self, name, value, unit)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value
    character(*), intent(in) :: unit
    type(xdmf_number_t), allocatable :: numbers(:)
    integer :: n

    n = size(self%grid%numbers)
    allocate (numbers(n + 1))
    numbers(:n) = self%grid%numbers
    numbers(n + 1)%name = name
    if (len(unit) > 0 .and. unit /= '-') numbers(n + 1)%name = name // ' [' // unit // ']'
    numbers(n + 1)%value = value
    call move_alloc(numbers, self%grid%numbers)
  end subroutine note_number

  !> Adds a field of one number per node to the present point. A wrong number of values is an error, which close returns.
  subroutine add_node_scalar(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    !> [unit] shape (n_nodes)
    real(rk), intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    if (.not. is_size_right(self, name, size(values), self%mesh%n_nodes)) return
    call self%add_array(name, values, unit, description)
    call note_field(self, name, n_components=1)
  end subroutine add_node_scalar

  !> Adds a field of several numbers per node to the present point. 1 or 2 components get zeros up to 3; 4 components, of a
  !> symmetric tensor, get zeros up to 6; other fields stay as they are. A wrong number of nodes is an error, which close returns.
  subroutine add_node_vector(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    !> [unit] shape (n_components, n_nodes)
    real(rk), intent(in) :: values(:, :)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    if (.not. is_size_right(self, name, size(values, 2), self%mesh%n_nodes)) return
    call add_components(self, name, values, unit, description, .false.)
  end subroutine add_node_vector

  !> Adds a field of one number per cell to the present point. A wrong number of values is an error, which close returns.
  subroutine add_cell_scalar(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    !> [unit] shape (n_cells)
    real(rk), intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    if (.not. is_size_right(self, name, size(values), self%mesh%n_cells)) return
    call self%add_array(name, values, unit, description)
    call note_field(self, name, n_components=1, is_cell_field=.true.)
  end subroutine add_cell_scalar

  !> Adds a field of one whole number per cell to the present point. A wrong number of values is an error, which close returns.
  subroutine add_cell_integer(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    !> shape (n_cells)
    integer, intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    if (.not. is_size_right(self, name, size(values), self%mesh%n_cells)) return
    call self%add_array(name, values, unit, description)
    call note_field(self, name, n_components=1, is_cell_field=.true., is_integer=.true.)
  end subroutine add_cell_integer

  !> Adds a field of several numbers per cell to the present point. 1 or 2 components get zeros up to 3; 4 components, of a
  !> symmetric tensor, get zeros up to 6; other fields stay as they are. A wrong number of cells is an error, which close returns.
  subroutine add_cell_vector(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    !> [unit] shape (n_components, n_cells)
    real(rk), intent(in) :: values(:, :)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    if (.not. is_size_right(self, name, size(values, 2), self%mesh%n_cells)) return
    call add_components(self, name, values, unit, description, .true.)
  end subroutine add_cell_vector

  subroutine add_components(self, name, values, unit, description, is_cell_field)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: values(:, :)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description
    logical, intent(in) :: is_cell_field
    integer :: n_components

    select case (size(values, 1))
    case (1:3)
      n_components = 3
      call self%add_array(name, padded(values, n_components), unit, description)
    case (4, 6)
      n_components = 6
      call self%add_array(name, padded(values, n_components), unit, description)
      call self%file%write(self%group // '/' // name // '@components', 'xx, yy, zz, xy, yz, xz')
    case default
      n_components = size(values, 1)
      call self%add_array(name, values, unit, description)
    end select
    call note_field(self, name, n_components, is_cell_field)
  end subroutine add_components

  !> Returns the values, with zeros behind them for the missing components; shape (n_components, n).
  pure function padded(values, n_components) result(all_values)
    !> shape (up to n_components, n)
    real(rk), intent(in) :: values(:, :)
    integer, intent(in) :: n_components
    real(rk), allocatable :: all_values(:, :)

    allocate (all_values(n_components, size(values, 2)), source=0.0_rk)
    all_values(:size(values, 1), :) = values
  end function padded

  !> Whether n = n_expected. If not, keeps an error for close, unless there is one already: no viewer would open such a file.
  logical function is_size_right(self, name, n, n_expected)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: n
    integer, intent(in) :: n_expected

    is_size_right = n == n_expected
    if (is_size_right .or. allocated(self%error)) return
    call make_error(self%error, 'the field ' // name // ' is given at ' // to_text(n) // ' nodes or cells where the mesh ' // &
      'has ' // to_text(n_expected), file=self%path, exit_code=exit_internal)
  end function is_size_right

  !> Lists a field of the point for the XDMF file. (gfortran 12 never frees what a constructor of xdmf_field_t allocates.)
  subroutine note_field(self, name, n_components, is_cell_field, is_integer)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    !> of the array in the file, with the zeros that were added
    integer, intent(in) :: n_components
    !> false by default
    logical, intent(in), optional :: is_cell_field, is_integer
    type(xdmf_field_t), allocatable :: fields(:)
    integer :: n_fields

    associate (grid => self%grid)
      n_fields = size(grid%fields)
      allocate (fields(n_fields + 1))
      fields(:n_fields) = grid%fields
      associate (field => fields(n_fields + 1))
        field%name = name
        field%address = self%group // '/' // name
        field%n_components = n_components
        if (present(is_cell_field)) field%is_cell_field = is_cell_field
        if (present(is_integer)) field%is_integer = is_integer
      end associate
      call move_alloc(fields, grid%fields)
    end associate
  end subroutine note_field

  !> Adds an array of the present point that is not a field of the mesh: of any size, in the HDF5 file only.
  subroutine add_real_array(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write(self%group // '/' // name, values, unit, description)
  end subroutine add_real_array

  subroutine add_real_matrix(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: values(:, :)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write(self%group // '/' // name, values, unit, description)
  end subroutine add_real_matrix

  subroutine add_integer_array(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write(self%group // '/' // name, values, unit, description)
  end subroutine add_integer_array

  !> Adds an array that belongs to no point, to the HDF5 file only. The name is a path from its root, e.g. `contact/areas`.
  subroutine add_shared_reals(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write('/' // name, values, unit, description)
  end subroutine add_shared_reals

  subroutine add_shared_matrix(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: values(:, :)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write('/' // name, values, unit, description)
  end subroutine add_shared_matrix

  subroutine add_shared_integers(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write('/' // name, values, unit, description)
  end subroutine add_shared_integers

  subroutine add_shared_texts(self, name, values, unit, description)
    class(field_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    type(string_t), intent(in) :: values(:)
    character(*), intent(in) :: unit
    character(*), intent(in) :: description

    call self%file%write('/' // name, values, unit, description)
  end subroutine add_shared_texts

  !> Completes the files and gives them their final names, the XDMF file last. Errors: the first failure since create, or the HDF5
  !> file cannot be completed (then there are no new files); the XDMF file cannot be written (then the HDF5 file is new already).
  subroutine close_file(self, error)
    class(field_file_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    if (allocated(self%error)) then
      call self%file%discard()
      call move_alloc(self%error, error)
      return
    end if
    call self%file%close(error)
    if (allocated(error)) return
    call end_grid(self)
    call self%xdmf%add(xdmf_tail())
    call write_text_file(without_ending(self%path) // '.xdmf', self%xdmf%text(), error)
  end subroutine close_file

  pure function without_ending(path) result(start)
    character(*), intent(in) :: path
    character(:), allocatable :: start

    start = path(:index(path, '/', back=.true.)) // base_name(path)
  end function without_ending
end module sig_field_file
