! SPDX-License-Identifier: BSD-3-Clause
!> Properties of materials that flow, such as a yield stress: expressions of the numbers of a state (parameters, time, tables) and
!> of the temperature at a point, which is a sum of parts: an expression of the state times a value at the point.
module sig_flow_properties
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_errors, only: error_t
  use sig_expression, only: expression_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: compiled_properties_t, flow_properties_t, temperature_name

  !> name of the temperature in properties
  character(*), parameter :: temperature_name = 'T'

  type :: flow_properties_t
    !> names of the numbers of a state
    type(string_t), allocatable :: names(:)
    !> expressions of one material after the other, in the order of its law, none of elastic ones; those of material m are
    !> starts(m) + 1 to starts(m + 1)
    type(string_t), allocatable :: texts(:)
    integer, allocatable :: starts(:)
    !> expressions of the parts of the temperature
    type(string_t), allocatable :: temperatures(:)
  contains
    procedure :: complete
    procedure :: mismatch
    procedure :: n_most
    procedure :: write
    procedure :: read
    procedure :: compile
  end type flow_properties_t

  !> The expressions, compiled for one thread.
  type :: compiled_properties_t
    private
    type(expression_t), allocatable :: properties(:)
    !> whether each contains the temperature
    logical, allocatable :: is_hot(:)
    integer, allocatable :: starts(:)
    type(expression_t), allocatable :: temperatures(:)
  contains
    procedure :: evaluate
    procedure :: temperature
    final :: free
  end type compiled_properties_t

contains

  !> Allocates the arrays that are not allocated, with size 0.
  pure subroutine complete(self)
    class(flow_properties_t), intent(inout) :: self

    if (.not. allocated(self%names)) allocate (self%names(0))
    if (.not. allocated(self%texts)) allocate (self%texts(0))
    if (.not. allocated(self%starts)) allocate (self%starts(0))
    if (.not. allocated(self%temperatures)) allocate (self%temperatures(0))
  end subroutine complete

  !> Returns the name of an array whose values do not fit; empty when all fit. Requires: complete.
  pure function mismatch(self, n_materials) result(name)
    class(flow_properties_t), intent(in) :: self
    integer, intent(in) :: n_materials
    character(:), allocatable :: name

    name = ''
    if (size(self%starts) /= n_materials + 1) then
      name = 'starts'
    else if (self%starts(1) /= 0 .or. self%starts(n_materials + 1) /= size(self%texts)) then
      name = 'starts'
    else if (any(self%starts(2:) < self%starts(:n_materials))) then
      name = 'starts'
    end if
  end function mismatch

  !> Returns the largest number of properties of a material. Requires: complete.
  pure integer function n_most(self)
    class(flow_properties_t), intent(in) :: self

    n_most = maxval(self%starts(2:) - self%starts(:size(self%starts) - 1))
  end function n_most

  !> Writes the expressions to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group)
    class(flow_properties_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group

    call file%write(group // '/names', self%names, description='numbers that expressions may contain, besides the temperature T')
    call file%write(group // '/expressions', self%texts, description='properties of one material after the other')
    call file%write(group // '/starts', self%starts, description='number of properties before those of each material')
    call file%write(group // '/temperatures', self%temperatures, description='factor of each part of the temperature')
  end subroutine write

  !> Reads what `write` writes. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(flow_properties_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/names', self%names, error)
    call file%read(group // '/expressions', self%texts, error)
    call file%read(group // '/starts', self%starts, error)
    call file%read(group // '/temperatures', self%temperatures, error)
  end subroutine read

  !> Compiles the expressions for one thread. Errors: message is allocated when one is not valid.
  subroutine compile(self, compiled, message)
    class(flow_properties_t), intent(in) :: self
    type(compiled_properties_t), intent(inout) :: compiled
    character(:), allocatable, intent(out) :: message
    type(string_t), allocatable :: names(:)
    integer :: i

    allocate (names, source=self%names)
    call append_text(names, temperature_name)
    compiled%starts = self%starts
    allocate (compiled%properties(size(self%texts)), compiled%is_hot(size(self%texts)))
    allocate (compiled%temperatures(size(self%temperatures)))
    do i = 1, size(self%texts)
      call compiled%properties(i)%create(self%texts(i)%text, names, message, .true.)
      if (allocated(message)) return
      compiled%is_hot(i) = compiled%properties(i)%uses(temperature_name)
    end do
    do i = 1, size(self%temperatures)
      call compiled%temperatures(i)%create(self%temperatures(i)%text, self%names, message, .true.)
      if (allocated(message)) return
    end do
  end subroutine compile

  !> Computes the properties at some points. A property without a finite value becomes not a number, for which laws have no answer.
  subroutine evaluate(self, state, materials, temperatures, properties)
    class(compiled_properties_t), intent(in) :: self
    !> shape (size(names))
    real(rk), intent(in) :: state(:)
    !> of each point, 1-based
    integer, intent(in) :: materials(:)
    !> [degree] values of the parts, shape (n_points, n_parts)
    real(rk), intent(in) :: temperatures(:, :)
    !> shape (n_most_properties, n_points)
    real(rk), intent(inout) :: properties(:, :)
    real(rk) :: cold(size(self%properties)), degrees(size(materials)), no_number, values(size(state) + 1)
    integer :: i, k
    logical :: is_valid

    no_number = ieee_value(no_number, ieee_quiet_nan)
    values = [state, 0.0_rk]
    degrees = self%temperature(state, temperatures)
    do i = 1, size(cold)
      if (self%is_hot(i)) cycle
      call self%properties(i)%evaluate(values, cold(i), is_valid)
      if (.not. is_valid) cold(i) = no_number
    end do
    do i = 1, size(materials)
      values(size(values)) = degrees(i)
      associate (first => self%starts(materials(i)))
        do k = 1, self%starts(materials(i) + 1) - first
          if (self%is_hot(first + k)) then
            call self%properties(first + k)%evaluate(values, properties(k, i), is_valid)
            if (.not. is_valid) properties(k, i) = no_number
          else
            properties(k, i) = cold(first + k)
          end if
        end do
      end associate
    end do
  end subroutine evaluate

  !> Returns the temperature [degree] at some points; one without a finite factor is not a number.
  function temperature(self, state, temperatures) result(degrees)
    class(compiled_properties_t), intent(in) :: self
    !> shape (size(names))
    real(rk), intent(in) :: state(:)
    !> [degree] values of the parts, shape (n_points, n_parts)
    real(rk), intent(in) :: temperatures(:, :)
    real(rk) :: degrees(size(temperatures, 1))
    real(rk) :: factors(size(temperatures, 2))
    integer :: i
    logical :: is_valid

    do i = 1, size(factors)
      call self%temperatures(i)%evaluate(state, factors(i), is_valid)
      if (.not. is_valid) factors(i) = ieee_value(factors(i), ieee_quiet_nan)
    end do
    degrees = matmul(temperatures, factors)
  end function temperature

  !> Frees the compiled expressions.
  subroutine free(self)
    type(compiled_properties_t), intent(inout) :: self
    integer :: i

    if (allocated(self%properties)) then
      do i = 1, size(self%properties)
        call self%properties(i)%destroy()
      end do
    end if
    if (.not. allocated(self%temperatures)) return
    do i = 1, size(self%temperatures)
      call self%temperatures(i)%destroy()
    end do
  end subroutine free
end module sig_flow_properties
