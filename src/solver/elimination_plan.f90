! SPDX-License-Identifier: BSD-3-Clause
!> What an elimination for W = B K^-1 B' is asked for, what it will take, and the file that keeps its result for later commands: it
!> may take minutes, and a run that is killed later need not do it again.
module sig_elimination_plan
  use sig_errors, only: error_t
  use sig_file_system, only: file_exists
  use sig_hdf5_format, only: file_format_t, open_sealed, write_format
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_memory, only: memory_text
  use sig_progress, only: duration_text
  use sig_shape_checks, only: place_in_ascending
  use sig_solver_costs, only: cost_t
  use sig_version, only: code_version
  implicit none(type, external)
  private
  public :: elimination_plan_t

  type(file_format_t), parameter :: kept_format = file_format_t('signorom compliance', 1, 1, 'remove the file')

  !> Set the components; an elimination with the defaults gives W alone and is not kept.
  type :: elimination_plan_t
    !> dofs whose displacements under each contact force are wanted, too; natural (order of the mesh file), ascending
    integer, allocatable :: dofs(:)
    !> file that keeps the result; empty: none
    character(:), allocatable :: path
    !> hash of the problem, as that of snapshots
    character(16) :: provenance = ''
    !> predicted, with factors or multigrid levels that are there beside it
    type(cost_t) :: cost
  contains
    procedure :: complete
    procedure :: announce
    procedure :: tell
    procedure :: read_kept
    procedure :: keep
  end type elimination_plan_t

  !> [s] shorter eliminations are not told
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Sets each component that is not set: no dof, no file.
  pure subroutine complete(self)
    class(elimination_plan_t), intent(inout) :: self

    if (.not. allocated(self%dofs)) allocate (self%dofs(0))
    if (.not. allocated(self%path)) self%path = ''
  end subroutine complete

  !> Logs what the elimination will take. MUMPS does it in one step, without a sign of progress.
  subroutine announce(self)
    class(elimination_plan_t), intent(in) :: self

    if (self%cost%seconds > seconds_of_silence) call log_info('eliminating the displacements takes about ' // &
      duration_text(self%cost%seconds) // ' and ' // memory_text(self%cost%bytes) // ', in one step without a sign of ' // &
      'progress; what is killed meanwhile begins again')
  end subroutine announce

  !> Logs what the elimination has taken.
  subroutine tell(self, seconds)
    class(elimination_plan_t), intent(in) :: self
    !> [s] wall time
    real(rk), intent(in) :: seconds

    if (max(seconds, self%cost%seconds) > seconds_of_silence) call log_info('displacements eliminated in ' // &
      duration_text(seconds) // ' (predicted: ' // duration_text(self%cost%seconds) // ')')
  end subroutine tell

  !> Reads W, and the responses of the dofs, if the file is there, of the same problem and version of the program, and has them. A
  !> file that is damaged gives a warning. Local; the log says that nothing is eliminated again.
  subroutine read_kept(self, compliance, response, is_there)
    class(elimination_plan_t), intent(in) :: self
    !> [length/force] shape (n_rows, n_rows); changes only if is_there
    real(rk), intent(inout) :: compliance(:, :)
    !> [length/force] displacements of the dofs under each contact force, shape (size(dofs), n_rows); changes only if is_there
    real(rk), intent(inout) :: response(:, :)
    logical, intent(out) :: is_there
    type(h5_reader_t) :: file
    type(error_t), allocatable :: error
    integer :: version

    is_there = .false.
    if (self%path == '') return
    if (.not. file_exists(self%path)) return
    call open_sealed(file, self%path, kept_format, version, error)
    if (.not. allocated(error)) call read_fitting(self, file, compliance, response, is_there, error)
    call file%close()
    if (allocated(error)) call log_warning('the displacements are eliminated again: ' // self%path // ': ' // error%message)
    if (is_there) call log_info('the matrix of all contacts comes from ' // self%path // ': nothing is eliminated again')
  end subroutine read_kept

  !> Reads the matrices of an open file if they are those that are wanted; the file may have more dofs. Errors: the file lacks
  !> something.
  subroutine read_fitting(self, file, compliance, response, is_there, error)
    class(elimination_plan_t), intent(in) :: self
    type(h5_reader_t), intent(in) :: file
    real(rk), intent(inout) :: compliance(:, :)
    real(rk), intent(inout) :: response(:, :)
    logical, intent(out) :: is_there
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: provenance, version
    integer, allocatable :: dofs(:), places(:)
    real(rk), allocatable :: kept(:, :), kept_response(:, :)
    integer :: i

    is_there = .false.
    call file%read('/@provenance', provenance, error)
    call file%read('/@code_version', version, error)
    call file%read('/dofs', dofs, error)
    if (allocated(error)) return
    if (provenance /= self%provenance .or. version /= code_version) return
    places = [(place_in_ascending(dofs, self%dofs(i)), i=1, size(self%dofs))]
    if (any(places == 0)) return
    call file%read('/response', kept_response, error)
    call file%read('/compliance', kept, error)
    if (allocated(error)) return
    is_there = all(shape(kept) == shape(compliance)) .and. all(shape(kept_response) == [size(dofs), size(response, 2)])
    if (.not. is_there) return
    compliance = kept
    response = kept_response(places, :)
  end subroutine read_fitting

  !> Writes the file, in place of an older one. A failure is a warning in the log. Local.
  subroutine keep(self, compliance, response)
    class(elimination_plan_t), intent(in) :: self
    !> as in read_kept
    real(rk), intent(in) :: compliance(:, :)
    real(rk), intent(in) :: response(:, :)
    type(h5_writer_t) :: file
    type(error_t), allocatable :: error

    if (self%path == '') return
    call file%create(self%path, error, is_sealed=.true.)
    if (.not. allocated(error)) then
      call write_format(file, kept_format, kept_format%newest, code_version)
      call file%write('/@provenance', self%provenance)
      call file%write('/compliance', compliance, description='openings of all contacts under each contact force, before ' // &
        'bodies that only contact holds are moved')
      call file%write('/dofs', self%dofs, description='dofs whose responses are kept, 1-based')
      call file%write('/response', response, description='displacements of these dofs under each contact force')
      call file%close(error)
    end if
    if (allocated(error)) call log_warning('a later command will eliminate the displacements again: ' // self%path // ': ' // &
      error%message)
  end subroutine keep
end module sig_elimination_plan
