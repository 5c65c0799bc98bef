! SPDX-License-Identifier: BSD-3-Clause
!> The snapshots of a study as one set: reads and writes snapshots.h5, and finds snapshots by their points.
module sig_snapshot_store
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_errors, only: error_t, make_error
  use sig_hdf5_format, only: file_format_t, open_sealed, write_format
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: column_t, h5_writer_t
  use sig_kinds, only: rk
  use sig_parameter_space, only: format_point, point_index
  use sig_snapshot_shard, only: move_record, n_residuals, snapshot_record_t
  use sig_text, only: string_t
  use sig_version, only: code_version
  implicit none(type, external)
  private
  public :: snapshot_set_t, columns_of
  public :: pick_records, read_snapshot_set, records_of_set, write_snapshots

  !> 2: with a seal
  type(file_format_t), parameter :: snapshots_format = &
    file_format_t('signorom snapshots', 2, 2, 'remove the file; signorom sample DECK writes one')
  character(*), parameter :: sample_again = 'remove the file and sample again'

  !> The solutions at m points, one per column. Points that did not converge are in the set, too.
  type :: snapshot_set_t
    !> hash of the deck's physics and of the mesh
    character(16) :: provenance = ''
    type(string_t), allocatable :: parameter_names(:)
    !> shape (n_parameters, m)
    real(rk), allocatable :: parameters(:, :)
    !> [length] displacement of the dofs that this rank has, natural, from first_dof on; shape (n_own, m)
    real(rk), allocatable :: displacement(:, :)
    integer :: first_dof = 1
    !> number of dofs of all ranks; 0 if the set has contact forces only
    integer :: n_dofs = 0
    !> [force] shape (n_multipliers, m)
    real(rk), allocatable :: multipliers(:, :)
    integer, allocatable :: n_iterations(:)
    !> > 0 solved, < 0 failed: constants of sig_reasons; shape (m)
    integer, allocatable :: reasons(:)
    !> equilibrium, penetration, negative multiplier, complementarity, force balance; shape (5, m)
    real(rk), allocatable :: residuals(:, :)
    !> [s] wall time, shape (m)
    real(rk), allocatable :: seconds(:)
    !> theta_t as expressions of the parameters; the first is 1
    type(string_t), allocatable :: term_texts(:)
    !> [length] response to the prescribed values of each term without contact, shape (n_dofs, n_terms)
    real(rk), allocatable :: free_response(:, :)
  end type snapshot_set_t

contains

  !> Reduces a set to the snapshots of the given points, in their order. A point without a snapshot gets no column. Of several
  !> snapshots of one point the last solved one is taken, or the first one if none is solved.
  pure subroutine take_points(set, points, is_missing, numbers)
    type(snapshot_set_t), intent(inout) :: set
    !> each only once; they replace the parameters of the snapshots, which may differ by rounding; shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> whether the set has no snapshot of the point, shape (n_points)
    logical, intent(out) :: is_missing(:)
    !> numbers that the taken columns had in the set before, 1-based
    integer, allocatable, intent(out) :: numbers(:)
    integer :: column_of_point(size(points, 2)), i

    column_of_point = columns_of_points(set%parameters, set%reasons, points)
    is_missing = column_of_point == 0
    numbers = pack(column_of_point, .not. is_missing)
    set = columns_of(set, numbers)
    set%parameters = points(:, pack([(i, i=1, size(points, 2))], .not. is_missing))
  end subroutine take_points

  !> Picks the records of the given points, in their order. Their arrays are moved, not copied: the picked elements of `records`
  !> have none afterwards, the others keep theirs. Of several records of one point the last solved one is taken, or the first one
  !> if none is solved.
  pure subroutine pick_records(records, points, picked, is_missing)
    type(snapshot_record_t), intent(inout) :: records(:)
    !> each only once; they replace the parameters of the records, which may differ by rounding; shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> one per point that has a record
    type(snapshot_record_t), allocatable, intent(out) :: picked(:)
    !> whether the point has no record, shape (n_points)
    logical, intent(out) :: is_missing(:)
    integer :: record_of_point(size(points, 2)), i_column, i_point
    real(rk) :: found(size(points, 1), size(records))

    do i_column = 1, size(records)
      found(:, i_column) = records(i_column)%parameters
    end do
    record_of_point = columns_of_points(found, records%reason, points)
    is_missing = record_of_point == 0
    allocate (picked(count(.not. is_missing)))
    i_column = 0
    do i_point = 1, size(points, 2)
      if (is_missing(i_point)) cycle
      i_column = i_column + 1
      call move_record(records(record_of_point(i_point)), picked(i_column))
      picked(i_column)%parameters = points(:, i_point)
    end do
  end subroutine pick_records

  !> Returns for each point the number of its column in `found`: that of the last solved one, or of the first one if none is solved;
  !> 0 if there is none. Requires: no point occurs twice in `points`.
  pure function columns_of_points(found, reasons, points) result(column_of_point)
    !> shape (n_parameters, n_found)
    real(rk), intent(in) :: found(:, :)
    !> > 0 solved; shape (n_found)
    integer, intent(in) :: reasons(:)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    integer :: column_of_point(size(points, 2))
    integer :: i_column, i_point

    column_of_point = 0
    i_point = 0
    do i_column = 1, size(reasons)
      i_point = point_index(points, found(:, i_column), i_point)
      if (i_point == 0) cycle
      if (column_of_point(i_point) == 0 .or. reasons(i_column) > 0) column_of_point(i_point) = i_column
    end do
  end function columns_of_points

  !> Returns a record for each snapshot of the set, with copies of its arrays. Of the displacement it has the dofs that the set has.
  pure function records_of_set(set) result(records)
    type(snapshot_set_t), intent(in) :: set
    !> shape (m)
    type(snapshot_record_t), allocatable :: records(:)
    integer :: i

    allocate (records(size(set%reasons)))
    do i = 1, size(records)
      records(i)%parameters = set%parameters(:, i)
      records(i)%displacement = set%displacement(:, i)
      records(i)%multipliers = set%multipliers(:, i)
      records(i)%n_iterations = set%n_iterations(i)
      records(i)%reason = set%reasons(i)
      records(i)%residuals = set%residuals(:, i)
      records(i)%seconds = set%seconds(i)
    end do
  end function records_of_set

  !> Returns a set of copies of the snapshots with these numbers, in this order; names, terms and the free response are copied, too.
  pure function columns_of(set, numbers) result(chosen)
    type(snapshot_set_t), intent(in) :: set
    !> 1-based
    integer, intent(in) :: numbers(:)
    type(snapshot_set_t) :: chosen

    chosen%provenance = set%provenance
    if (allocated(set%parameter_names)) chosen%parameter_names = set%parameter_names
    if (allocated(set%term_texts)) chosen%term_texts = set%term_texts
    if (allocated(set%free_response)) chosen%free_response = set%free_response
    chosen%parameters = set%parameters(:, numbers)
    if (allocated(set%displacement)) chosen%displacement = set%displacement(:, numbers)
    chosen%first_dof = set%first_dof
    chosen%n_dofs = set%n_dofs
    chosen%multipliers = set%multipliers(:, numbers)
    chosen%n_iterations = set%n_iterations(numbers)
    chosen%reasons = set%reasons(numbers)
    chosen%residuals = set%residuals(:, numbers)
    chosen%seconds = set%seconds(numbers)
  end function columns_of

  !> Writes a file such as snapshots.h5 from records, and replaces an existing one as a whole. It has a seal, by which a reader
  !> notices changes of the file. h5py shows the snapshots as rows: displacement has shape (m, n_dofs).
  !>
  !> Errors: the file cannot be written.
  subroutine write_snapshots(path, study, records, length_unit, multiplier_unit, parameter_units, error)
    character(*), intent(in) :: path
    !> its provenance, names, terms and free response are written, not its snapshots
    type(snapshot_set_t), intent(in) :: study
    !> shape (m)
    type(snapshot_record_t), intent(in), target :: records(:)
    !> unit of the displacements
    character(*), intent(in) :: length_unit
    !> unit of force, in plane models of force per length
    character(*), intent(in) :: multiplier_unit
    !> in the order of the names of the parameters
    type(string_t), intent(in) :: parameter_units(:)
    type(error_t), allocatable, intent(out) :: error
    type(h5_writer_t) :: file

    call file%create(path, error, is_sealed=.true.)
    if (allocated(error)) return
    call write_format(file, snapshots_format, snapshots_format%newest, code_version)
    call file%write('/@provenance', study%provenance)
    call file%write('/parameter_names', study%parameter_names, description='in the order of the columns of parameters')
    call write_fields(file, records, size(study%parameter_names), length_unit, multiplier_unit)
    call file%write('/parameters@units', parameter_units)
    call file%write('/iterations', records%n_iterations, description='iterations of the contact solver')
    call file%write('/reasons', records%reason, description='> 0 solved, < 0 failed')
    call file%write('/seconds', records%seconds, 's', 'wall time of the solution')
    call file%write('/term_texts', study%term_texts, description='factors of the free responses, expressions of the parameters')
    call file%write('/free_response', study%free_response, length_unit, 'displacement under each term without contact')
    call file%close(error)
  end subroutine write_snapshots

  !> Writes the parameters, displacements, multipliers and residuals, a column per record. Requires: the arrays of all records have
  !> the same sizes. `file` keeps a failure until it is closed.
  subroutine write_fields(file, records, n_parameters, length_unit, multiplier_unit)
    type(h5_writer_t), intent(inout) :: file
    type(snapshot_record_t), intent(in), target :: records(:)
    integer, intent(in) :: n_parameters
    character(*), intent(in) :: length_unit
    character(*), intent(in) :: multiplier_unit
    type(column_t), dimension(size(records)) :: parameters, displacement, multipliers, residuals
    integer :: i, n_dofs, n_multipliers

    n_dofs = 0
    n_multipliers = 0
    do i = 1, size(records)
      parameters(i)%values => records(i)%parameters
      displacement(i)%values => records(i)%displacement
      multipliers(i)%values => records(i)%multipliers
      residuals(i)%values => records(i)%residuals
      n_dofs = size(records(i)%displacement)
      n_multipliers = size(records(i)%multipliers)
    end do
    call file%write_columns('/parameters', parameters, n_parameters, &
      description='parameter points, one per snapshot; units: see attribute')
    call file%write_columns('/displacement', displacement, n_dofs, length_unit, &
      'nodal displacement, dof = n_dim * (node - 1) + component')
    call file%write_columns('/multipliers', multipliers, n_multipliers, multiplier_unit, 'contact force of each contact row, >= 0')
    call file%write_columns('/residuals', residuals, n_residuals, description= &
      'equilibrium (relative), penetration (' // length_unit // '), negative multiplier (relative), ' // &
      'complementarity (relative), force balance (relative)')
  end subroutine write_fields

  !> Reads a file such as snapshots.h5. Of the displacements only the wanted dofs and points are read into memory.
  !>
  !> Errors: the file is missing, no HDF5 file or no file of snapshots, has another format version, is cut off or changed, is of
  !> another provenance, has datasets that are missing or do not fit together, or values that are not finite in the points, the free
  !> response or what is read of solved snapshots.
  subroutine read_snapshot_set(path, provenance, set, error, dofs, points, is_missing)
    character(*), intent(in) :: path
    !> provenance of the deck and mesh in use; blank accepts any
    character(*), intent(in) :: provenance
    type(snapshot_set_t), intent(out) :: set
    type(error_t), allocatable, intent(out) :: error
    !> first and last dof whose displacements are read, 1-based; none if the last is smaller; default: all
    integer, intent(in), optional :: dofs(2)
    !> only the snapshots of these points are read, in their order; shape (n_parameters, n_points); needs is_missing
    real(rk), intent(in), optional :: points(:, :)
    !> whether the point has no snapshot, shape (n_points)
    logical, intent(out), optional :: is_missing(:)
    type(h5_reader_t) :: file
    integer, allocatable :: numbers(:)
    integer :: i, version

    if (present(is_missing)) is_missing = .true.
    call open_sealed(file, path, snapshots_format, version, error)
    if (allocated(error)) return
    work: block
      call read_small_parts(file, path, provenance, set, error)
      if (allocated(error)) exit work
      numbers = [(i, i=1, size(set%reasons))]
      if (present(points)) call take_points(set, points, is_missing, numbers)
      call read_displacement(file, numbers, set, error, dofs)
    end block work
    call file%close()
    if (allocated(error)) return
    call refuse_no_numbers(path, set, error)
  end subroutine read_snapshot_set

  !> Reads all datasets but the displacements, of which it reads the number of dofs.
  !>
  !> Errors: those of read_head, a missing dataset, datasets that do not fit together, a point that is not finite.
  subroutine read_small_parts(file, path, provenance, set, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: path
    character(*), intent(in) :: provenance
    type(snapshot_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: shape(:)

    call read_head(file, path, provenance, set, error)
    call file%read('/parameter_names', set%parameter_names, error)
    call file%read('/parameters', set%parameters, error)
    call file%get_shape('/displacement', shape, error)
    call file%read('/multipliers', set%multipliers, error)
    call file%read('/iterations', set%n_iterations, error)
    call file%read('/reasons', set%reasons, error)
    call file%read('/residuals', set%residuals, error)
    call file%read('/seconds', set%seconds, error)
    call file%read('/term_texts', set%term_texts, error)
    call file%read('/free_response', set%free_response, error)
    if (allocated(error)) return
    if (size(shape) == 2) set%n_dofs = shape(1)
    if (.not. has_matching_shapes(set, shape)) then
      call make_error(error, 'the snapshots are damaged: the datasets do not fit together', file=path, hint=sample_again)
    else if (.not. all(ieee_is_finite(set%parameters))) then
      ! points are looked for later, and such a point would not be found
      call make_error(error, 'the snapshots are damaged: a parameter of a point is infinite or not a number', &
        file=path, hint=sample_again)
    end if
  end subroutine read_small_parts

  subroutine read_displacement(file, numbers, set, error, dofs)
    type(h5_reader_t), intent(in) :: file
    !> numbers of the columns in the file
    integer, intent(in) :: numbers(:)
    type(snapshot_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(inout) :: error
    integer, intent(in), optional :: dofs(2)
    integer :: last

    last = set%n_dofs
    if (present(dofs)) then
      set%first_dof = dofs(1)
      last = min(last, dofs(2))
    end if
    call file%read_block('/displacement', set%first_dof, last, numbers, set%displacement, error)
  end subroutine read_displacement

  !> Errors: the free response or a solved snapshot contains a value that is not finite, which would spoil all modes. The message
  !> names the point of the snapshot.
  subroutine refuse_no_numbers(path, set, error)
    character(*), intent(in) :: path
    type(snapshot_set_t), intent(in) :: set
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (.not. all(ieee_is_finite(set%free_response))) call make_error(error, &
      'the snapshots are damaged: the displacement without contact contains infinite values or values that are not numbers', &
      file=path, hint=sample_again)
    do i = 1, size(set%reasons)
      if (set%reasons(i) <= 0) cycle
      if (all(ieee_is_finite(set%displacement(:, i))) .and. all(ieee_is_finite(set%multipliers(:, i)))) cycle
      call make_error(error, 'the snapshots are damaged: that of ' // format_point(set%parameter_names, set%parameters(:, i)) // &
        ' contains infinite values or values that are not numbers', file=path, hint=sample_again)
      return
    end do
  end subroutine refuse_no_numbers

  !> Sets set%provenance from the file. Errors: it is missing, or differs from `provenance` (blank accepts any), that is, the
  !> snapshots are of another deck or mesh.
  subroutine read_head(file, path, provenance, set, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: path
    character(*), intent(in) :: provenance
    type(snapshot_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: text

    call file%read('/@provenance', text, error)
    if (allocated(error)) return
    set%provenance = text
    if (provenance /= '' .and. set%provenance /= provenance) then
      call make_error(error, 'these snapshots belong to another deck, mesh or field file (provenance ' // set%provenance // &
                      ', not ' // provenance // ')', file=path, hint=sample_again // &
                      ', or choose another results folder (output.directory)')
    end if
  end subroutine read_head

  pure logical function has_matching_shapes(set, shape) result(is_matching)
    type(snapshot_set_t), intent(in) :: set
    !> shape of the displacements
    integer, intent(in) :: shape(:)
    integer :: n_snapshots

    is_matching = .false.
    if (size(shape) /= 2) return
    n_snapshots = size(set%parameters, 2)
    is_matching = all([shape(2), size(set%multipliers, 2), size(set%n_iterations), size(set%reasons), &
      size(set%residuals, 2), size(set%seconds)] == n_snapshots) &
      .and. size(set%parameter_names) == size(set%parameters, 1) .and. size(set%residuals, 1) == n_residuals &
      .and. size(set%free_response, 2) == size(set%term_texts) .and. size(set%free_response, 1) == shape(1)
  end function has_matching_shapes
end module sig_snapshot_store
