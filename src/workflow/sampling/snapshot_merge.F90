! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Finds the solutions that earlier runs left in a store of the results folder, and merges them with the shards of this run into one
!> file.
!>
!> A store is a file such as snapshots.h5, together with the shards snapshots.part-1, ... of a sampling that is not finished. Shards
!> of a share of the points have its label in their names: snapshots.part-2of4.1.
module sig_snapshot_merge
  use mpi, only: MPI_Barrier, MPI_Bcast, MPI_Comm_rank, MPI_INTEGER, MPI_LOGICAL
  use sig_condensed_plan, only: needs_displacements
  use sig_deck_units, only: force_unit
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_file_system, only: file_exists, list_files, remove_file
  use sig_full_order, only: team_t
  use sig_parameter_space, only: all_points
  use sig_petsc_support, only: rows_of_rank
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_problem, only: parameter_names, parameter_units, problem_t
  use sig_reasons, only: reason_converged, reason_text
  use sig_share, only: share_of_label, share_t
  use sig_snapshot_shard, only: append_records, check_shard, read_shard, shard_content_t, snapshot_record_t
  use sig_snapshot_store, only: pick_records, read_snapshot_set, records_of_set, snapshot_set_t, write_snapshots
  use sig_text, only: append_text, are, counted, string_t, to_text
  use petsc
  implicit none(type, external)
  private
  public :: find_finished_points, lacks_displacements, merge_snapshots, put_in_order, read_own_snapshots, read_spread, read_store
  public :: snapshots_path, store_in, store_t
  public :: write_merged

  !> names of the stores: the solutions on which a model is trained, and the solved candidates from which some are chosen
  character(*), parameter, public :: snapshot_store = 'snapshots'
  character(*), parameter, public :: candidate_store = 'candidates'

  !> stands behind the name of the store in those of its shards
  character(*), parameter :: part = '.part-'

  !> Where solutions are kept.
  type :: store_t
    !> results folder
    character(:), allocatable :: folder
    !> snapshot_store or candidate_store
    character(:), allocatable :: name
    !> what this run solves and writes; the merged file does not change where this is a share
    type(share_t) :: share
    !> damaged shards were reported, so that they are now left out without a warning
    logical, private :: is_reported = .false.
  contains
    procedure :: path => store_path
    procedure :: shard_path
    procedure :: shares_there
    procedure, private :: shards => list_shards
    procedure, private :: share_of
  end type store_t

contains

  !> Returns the path of snapshots.h5 in the results folder.
  pure function snapshots_path(folder) result(path)
    character(*), intent(in) :: folder
    character(:), allocatable :: path

    path = folder // '/' // snapshot_store // '.h5'
  end function snapshots_path

  !> Returns the store of a folder with a name. Use it instead of store_t(...): gfortran 12 loses a text there if the argument is
  !> itself a component, such as session%folder.
  pure function store_in(folder, name, share) result(store)
    character(*), intent(in) :: folder
    !> snapshot_store or candidate_store
    character(*), intent(in) :: name
    !> default: all points
    type(share_t), intent(in), optional :: share
    type(store_t) :: store

    store%folder = folder
    store%name = name
    if (present(share)) store%share = share
  end function store_in

  !> Returns the path of the merged file of the store: folder/snapshots.h5 or folder/candidates.h5.
  pure function store_path(self) result(path)
    class(store_t), intent(in) :: self
    character(:), allocatable :: path

    path = self%folder // '/' // self%name // '.h5'
  end function store_path

  !> Returns the path of the shard of a group of ranks (1-based), such as folder/snapshots.part-2, of a share
  !> folder/snapshots.part-3of4.2.
  pure function shard_path(self, i_group) result(path)
    class(store_t), intent(in) :: self
    integer, intent(in) :: i_group
    character(:), allocatable :: path

    path = self%folder // '/' // self%name // part
    if (self%share%is_used()) path = path // self%share%label() // '.'
    path = path // to_text(i_group)
  end function shard_path

  !> Returns the names, without the folder, of the shards that this run reads, also those of earlier runs, in byte order: all but
  !> those of other shares, to which other runs may be appending. None if the folder is missing.
  function list_shards(self) result(names)
    class(store_t), intent(in) :: self
    type(string_t), allocatable :: names(:)

    names = shards_of(self, .false.)
  end function list_shards

  !> Returns the names of the shards that belong to other shares than that of the store, or of those that do not. Without a share
  !> all shards are its own.
  function shards_of(store, others) result(names)
    type(store_t), intent(in) :: store
    logical, intent(in) :: others
    type(string_t), allocatable :: names(:)
    type(string_t), allocatable :: all_names(:)
    type(share_t) :: share
    logical :: is_other
    integer :: i

    all_names = list_files(store%folder, store%name // part)
    allocate (names(0))
    do i = 1, size(all_names)
      share = store%share_of(all_names(i)%text)
      is_other = store%share%is_used() .and. share%is_used() .and. .not. share%equals(store%share)
      if (is_other .eqv. others) call append_text(names, all_names(i)%text)
    end do
  end function shards_of

  !> Returns the share to which a shard belongs; one that is not used for a shard of all points.
  pure type(share_t) function share_of(self, shard) result(share)
    class(store_t), intent(in) :: self
    !> its name, without the folder
    character(*), intent(in) :: shard
    character(:), allocatable :: rest

    rest = shard(len(self%name // part) + 1:)
    share = share_of_label(rest(:index(rest // '.', '.') - 1))
  end function share_of

  !> Returns the shares of which there are shards, each as often as it has shards, one behind the other.
  function shares_there(self) result(shares)
    class(store_t), intent(in) :: self
    type(share_t), allocatable :: shares(:)
    type(string_t), allocatable :: names(:)
    integer :: i

    names = list_files(self%folder, self%name // part)
    allocate (shares(size(names)))
    do i = 1, size(names)
      shares(i) = self%share_of(names(i)%text)
    end do
    shares = pack(shares, shares%n_shares > 0)
  end function shares_there

  !> Errors: another share of the store was dealt for another number of shares, so that points would be solved twice; its shards are
  !> of another deck or mesh, or have other sizes.
  subroutine check_other_shares(problem, store, n_parameters, n_stored, error)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    integer, intent(in) :: n_parameters
    !> number of dofs of which the store keeps displacements: all or 0
    integer, intent(in) :: n_stored
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: names(:)
    type(share_t) :: share
    integer :: i

    names = shards_of(store, .true.)
    do i = 1, size(names)
      share = store%share_of(names(i)%text)
      if (share%n_shares /= store%share%n_shares) then
        call make_error(error, 'here are points of ' // share%words() // ', which do not go with ' // store%share%words(), &
          store%folder // '/' // names(i)%text, hint='all jobs must have the same number of shares; to begin with ' // &
          'another number, first merge the points that are there: signorom sample ' // problem%deck%path)
      else
        call check_shard(store%folder // '/' // names(i)%text, shard_content_t(problem%provenance, n_parameters, n_stored, &
          problem%force_rows%n_rows), error)
      end if
      if (allocated(error)) return
    end do
  end subroutine check_other_shares

  !> Finds out which points have a converged solution in the files of the store, and whether nothing is left to do. Missing files
  !> are no error. A merged file without displacements does not count if the deck needs displacements. Collective on all ranks;
  !> results and errors are the same on each.
  !>
  !> Errors: those of collect_snapshots, and of check_other_shares if the store has a share.
  subroutine find_finished_points(problem, store, points, is_done, is_merged, error, ierr, n_stored)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> the merged file or a shard has a converged solution of the point, shape (n_points)
    logical, allocatable, intent(out) :: is_done(:)
    !> all points are done, and there are no shards that this run would merge
    logical, intent(out) :: is_merged
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    !> as in collect_snapshots
    integer, intent(out), optional :: n_stored
    type(snapshot_record_t), allocatable :: records(:)
    type(string_t), allocatable :: shards(:)
    logical, allocatable :: is_missing(:)
    integer :: rank, i, i_column, n_dofs

    allocate (is_done(size(points, 2)), source=.false.)
    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    n_dofs = 0
    work: if (rank == 0) then
      call collect_snapshots(problem, store, points, records, is_missing, n_dofs, error)
      if (.not. allocated(error) .and. store%share%is_used()) &
        call check_other_shares(problem, store, size(points, 1), n_dofs, error)
      if (allocated(error)) exit work
      i_column = 0
      do i = 1, size(points, 2)
        if (is_missing(i)) cycle
        i_column = i_column + 1
        is_done(i) = records(i_column)%reason == reason_converged
      end do
    end if work
    shards = store%shards()
    is_merged = (size(shards) == 0 .or. store%share%is_used()) .and. all(is_done)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    call MPI_Bcast(is_done, size(is_done), MPI_LOGICAL, 0, PETSC_COMM_WORLD, ierr)
    call MPI_Bcast(is_merged, 1, MPI_LOGICAL, 0, PETSC_COMM_WORLD, ierr)
    call MPI_Bcast(n_dofs, 1, MPI_INTEGER, 0, PETSC_COMM_WORLD, ierr)
    if (present(n_stored)) n_stored = n_dofs
  end subroutine find_finished_points

  !> Reads all solutions of the store: first those of the given points, then those of other points that an earlier deck asked for.
  !> Of several solutions of a point (merged file, then shards, then `fresh`) the last converged one is kept, or the first one if
  !> none converged. A merged file without displacements is left out if the deck needs them, with a note in the log unless `fresh`
  !> is present. The records of a shard from the first damaged one on are left out, with a warning unless store%is_reported.
  !> Missing files are no error.
  !> Local.
  !>
  !> Errors: a file cannot be read, or is of another deck or mesh; the records of a shard do not have n_stored dofs.
  subroutine collect_snapshots(problem, store, points, picked, is_missing, n_stored, error, fresh)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> the solutions that are found, in the order of the points; also those that did not converge, by their reason
    type(snapshot_record_t), allocatable, intent(out) :: picked(:)
    !> no solution is found; of the given points, then of the others (false)
    logical, allocatable, intent(out) :: is_missing(:)
    !> number of dofs of which the store keeps displacements: all if the deck needs them or the merged file has them, else 0
    integer, intent(out) :: n_stored
    type(error_t), allocatable, intent(out) :: error
    !> records that are in no file yet; their arrays are moved away
    type(snapshot_record_t), intent(inout), optional :: fresh(:)
    type(snapshot_record_t), allocatable :: records(:), found(:)
    type(snapshot_set_t) :: set
    type(string_t), allocatable :: shards(:)
    real(rk), allocatable :: wanted(:, :)
    integer :: i, n_dropped

    allocate (records(0))
    n_stored = merge(problem%mesh%n_dim * problem%mesh%n_nodes, 0, needs_displacements(problem))
    if (file_exists(store%path())) then
      call read_own_snapshots(problem, store%path(), set, error)
      if (allocated(error)) return
      if (lacks_displacements(set) .and. n_stored > 0) then
        if (.not. present(fresh)) call log_info('the snapshots hold contact forces only, and this deck needs displacements: ' // &
          'its points are solved again, and the old solutions are dropped')
      else
        if (size(set%reasons) > 0) n_stored = set%n_dofs
        records = records_of_set(set)
      end if
    end if
    shards = store%shards()
    do i = 1, size(shards)
      call read_shard(store%folder // '/' // shards(i)%text, shard_content_t(problem%provenance, size(points, 1), n_stored, &
        problem%force_rows%n_rows), found, n_dropped, error)
      if (allocated(error)) return
      if (n_dropped > 0 .and. .not. store%is_reported) call log_warning(counted(n_dropped, 'record') // ' at the end of ' // &
        shards(i)%text // ' ' // are(n_dropped) // ' left out: damaged or behind a damaged one, as after a killed run; ' // &
        'points of the deck that were only there are solved again')
      call append_records(found, records)
    end do
    if (present(fresh)) call append_records(fresh, records)
    wanted = all_points(points, points_of(records, size(points, 1)))
    allocate (is_missing(size(wanted, 2)))
    call pick_records(records, wanted, picked, is_missing)
  end subroutine collect_snapshots

  !> Returns the parameter points of the records, shape (n_parameters, size(records)).
  pure function points_of(records, n_parameters) result(points)
    type(snapshot_record_t), intent(in) :: records(:)
    integer, intent(in) :: n_parameters
    real(rk) :: points(n_parameters, size(records))
    integer :: i

    do i = 1, size(records)
      points(:, i) = records(i)%parameters
    end do
  end function points_of

  !> Reads the merged file of a store: all points and dofs, or those of the optional arguments. Local.
  !>
  !> Errors: those of read_snapshot_set; the sizes are not those of the problem although the provenance is (not checked if no
  !> point is read).
  subroutine read_own_snapshots(problem, path, set, error, dofs, points, is_missing)
    type(problem_t), intent(in) :: problem
    character(*), intent(in) :: path
    type(snapshot_set_t), intent(out) :: set
    type(error_t), allocatable, intent(out) :: error
    !> as for read_snapshot_set
    integer, intent(in), optional :: dofs(2)
    real(rk), intent(in), optional :: points(:, :)
    logical, intent(out), optional :: is_missing(:)
    integer :: n_dofs, n_free_responses

    call read_snapshot_set(path, problem%provenance, set, error, dofs, points, is_missing)
    if (allocated(error)) return
    ! no point was solved yet: nothing has a size
    if (size(set%reasons) == 0) return
    n_dofs = problem%mesh%n_dim * problem%mesh%n_nodes
    n_free_responses = size(set%free_response, 2)
    if (size(set%parameter_names) /= size(problem%deck%state_parameters) .or. &
      size(set%multipliers, 1) /= problem%force_rows%n_rows .or. &
      all(set%n_dofs /= [0, n_dofs]) .or. n_free_responses > size(problem%lifted_terms)) &
      call make_error(error, 'the snapshots are not those of this deck and mesh: their sizes differ', file=path, &
        hint='remove the file and sample again')
  end subroutine read_own_snapshots

  !> Whether the set has points, and displacements of none of them, as for a condensed model, which needs contact forces only.
  pure logical function lacks_displacements(set)
    type(snapshot_set_t), intent(in) :: set

    lacks_displacements = size(set%reasons) > 0 .and. set%n_dofs == 0
  end function lacks_displacements

  !> Reads the solutions at the given points from the merged file, in their order, with all dofs that the file has; the file may
  !> have more points. Those that did not converge are included, by their reason. Local.
  !>
  !> Errors: the file cannot be read, or is of another deck or mesh.
  subroutine read_store(problem, store, points, set, is_missing, error)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> has no column for a missing point
    type(snapshot_set_t), intent(out) :: set
    !> the file lacks the point, shape (n_points)
    logical, intent(out) :: is_missing(:)
    type(error_t), allocatable, intent(out) :: error

    call read_own_snapshots(problem, store%path(), set, error, points=points, is_missing=is_missing)
  end subroutine read_store

  !> Does what read_store does, but each rank gets only its share of the dofs of the displacements: a block of consecutive dofs. It
  !> gets none if the deck needs no displacements, or if the file has none. All else is whole on each rank. Collective on all ranks;
  !> errors are known to all.
  subroutine read_spread(problem, store, points, set, is_missing, error, ierr)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    !> points, set and is_missing as for read_store
    real(rk), intent(in) :: points(:, :)
    type(snapshot_set_t), intent(out) :: set
    logical, intent(out) :: is_missing(:)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer :: dofs(2)

    PetscCall(rows_of_rank(problem%mesh%n_dim * problem%mesh%n_nodes, PETSC_COMM_WORLD, dofs(1), dofs(2), ierr))
    if (.not. needs_displacements(problem)) dofs = [1, 0]
    call read_own_snapshots(problem, store%path(), set, error, dofs, points, is_missing)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine read_spread

  !> Writes the merged file again so that the given points come first, in their order. Does nothing if the file begins with these
  !> points already. Local: one rank calls it. Requires: the merged file has all points. Errors: it cannot be read; those of
  !> write_merged.
  subroutine put_in_order(problem, store, points, error)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    type(snapshot_set_t) :: set
    type(snapshot_record_t) :: none(0)

    call read_own_snapshots(problem, store%path(), set, error)
    if (allocated(error)) return
    if (size(set%parameters, 2) >= size(points, 2)) then
      if (all(abs(set%parameters(:, :size(points, 2)) - points) <= 0)) return
    end if
    call write_merged(problem, store, points, none, set%free_response, error)
  end subroutine put_in_order

  !> Writes one file of all solutions of the store and of this run, the given points first, then removes the shards. Collective on
  !> all ranks; errors are known to all. Requires: find_finished_points of the store, which reported damaged shards.
  !>
  !> Errors: n_stored is not 0, and the elastic responses to the lifted terms cannot be computed; those of write_merged.
  subroutine merge_snapshots(problem, team, store, points, n_stored, fresh, error, ierr)
    type(problem_t), intent(in) :: problem
    !> all ranks, in groups; its solver is ready
    type(team_t), intent(inout) :: team
    type(store_t), intent(in) :: store
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> number of dofs of which the store keeps displacements: all or 0
    integer, intent(in) :: n_stored
    !> on the first rank its records that are in no shard, none on other ranks; their arrays are moved away
    type(snapshot_record_t), intent(inout) :: fresh(:)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(store_t) :: reported
    real(rk), allocatable :: response(:, :)
    integer :: reason

    reported = store
    reported%is_reported = .true.
    if (n_stored == 0) then
      ! a store without displacements needs no elastic responses
      allocate (response(n_stored, 0))
    else if (team%groups%i_group == 1) then
      PetscCall(team%solver%lifting(problem, response, reason, ierr))
      if (reason /= reason_converged) call make_error(error, 'no elastic response to the prescribed values and ' // &
        'imposed strains: ' // reason_text(reason), problem%deck%path, exit_code=exit_not_converged)
    end if
    call MPI_Barrier(PETSC_COMM_WORLD, ierr)
    if (team%groups%world_rank == 0 .and. .not. allocated(error)) &
      call write_merged(problem, reported, points, fresh, response, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine merge_snapshots

  !> Writes the merged file: the solutions that collect_snapshots keeps, the given points first; then removes the shards.
  !> Local: one rank calls it.
  !>
  !> Errors: those of collect_snapshots; a file cannot be written or removed.
  subroutine write_merged(problem, store, points, fresh, response, error)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> records that are in no file yet; their arrays are moved away
    type(snapshot_record_t), intent(inout) :: fresh(:)
    !> [length] elastic responses to the lifted terms, shape (n_dofs, n_lifted_terms); no column without displacements
    real(rk), intent(in) :: response(:, :)
    type(error_t), allocatable, intent(out) :: error
    type(snapshot_set_t) :: study
    type(snapshot_record_t), allocatable :: records(:)
    type(string_t), allocatable :: shards(:)
    logical, allocatable :: is_missing(:)
    integer :: i, n_stored

    call collect_snapshots(problem, store, points, records, is_missing, n_stored, error, fresh)
    if (allocated(error)) return
    study%provenance = problem%provenance
    study%parameter_names = parameter_names(problem%deck)
    study%term_texts = problem%terms%names(problem%lifted_terms(:size(response, 2)))
    study%free_response = response
    call write_snapshots(store%path(), study, records, problem%deck%units%length, force_unit(problem%deck), &
      parameter_units(problem%deck), error)
    if (allocated(error)) return
    shards = store%shards()
    do i = 1, size(shards)
      call remove_file(store%folder // '/' // shards(i)%text, error)
      if (allocated(error)) return
    end do
  end subroutine write_merged
end module sig_snapshot_merge
