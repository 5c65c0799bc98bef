! SPDX-License-Identifier: BSD-3-Clause
!> The data with which a hyper-reduced model bounds its errors where the matrix W of all contacts is too large to keep. Training
!> makes them and a file keeps them. In a model without them the arrays have no rows.
module sig_lifted_data
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_lifted_error_bound, only: sparse_matrix_t
  use sig_missing_parts, only: fill_missing
  use sig_shape_checks, only: are_indices, is_matrix
  implicit none(type, external)
  private
  public :: lifted_data_t

  type :: lifted_data_t
    !> [length per unit of theta] openings without contact forces, D - B G, shape (n_multipliers, n_terms)
    real(rk), allocatable :: free_opening(:, :)
    !> [length] W Lambda for the dual snapshots Lambda, shape (n_multipliers, n_snapshots)
    real(rk), allocatable :: snapshot_opening(:, :)
    !> [length/force] columns of W of the domain's rows, shape (n_multipliers, n_rows)
    real(rk), allocatable :: row_opening(:, :)
    !> [force] force patterns Y of energy 1, and [length] W Y; shape (n_multipliers, n_patterns)
    real(rk), allocatable :: pattern_forces(:, :)
    real(rk), allocatable :: pattern_opening(:, :)
    !> if only contact holds a body: rows whose forces balance the loads when these openings are computed
    integer, allocatable :: anchors(:)
    !> [force/length] L' K L
    type(sparse_matrix_t) :: lift
    !> [sqrt(force*length)] size of the largest snapshot in the norm of W
    real(rk) :: largest_size = 0
  contains
    procedure :: is_there
    procedure :: complete
    procedure :: mismatch
    procedure :: write
    procedure :: read
  end type lifted_data_t

contains

  !> Whether there are data for a bound.
  pure logical function is_there(self)
    class(lifted_data_t), intent(in) :: self

    is_there = allocated(self%free_opening)
    if (is_there) is_there = size(self%free_opening, 1) > 0
  end function is_there

  !> Allocates with size 0 each array of this type that is not allocated.
  pure subroutine complete(self)
    class(lifted_data_t), intent(inout) :: self

    call fill_missing(self%free_opening, 0)
    call fill_missing(self%snapshot_opening, 0)
    call fill_missing(self%row_opening, 0)
    call fill_missing(self%pattern_forces, 0)
    call fill_missing(self%pattern_opening, 0)
    call fill_missing(self%anchors)
    call fill_missing(self%lift%starts)
    call fill_missing(self%lift%columns)
    call fill_missing(self%lift%values)
  end subroutine complete

  !> Returns the name (`certificate/...`) of an array of this type whose shape, indices or values do not fit; empty when all fit, or
  !> when there are no data. Requires: complete or read.
  pure function mismatch(self, n_multipliers, n_terms, n_snapshots, n_rows, n_motions) result(name)
    class(lifted_data_t), intent(in) :: self
    integer, intent(in) :: n_multipliers
    integer, intent(in) :: n_terms
    !> number of dual snapshots
    integer, intent(in) :: n_snapshots
    !> number of rows of the domain
    integer, intent(in) :: n_rows
    !> number of rigid motions that only contact holds
    integer, intent(in) :: n_motions
    character(:), allocatable :: name

    name = ''
    if (.not. self%is_there()) return
    associate (n => n_multipliers, starts => self%lift%starts)
      if (.not. is_matrix(self%free_opening, n, n_terms)) name = 'certificate/free_opening'
      if (.not. is_matrix(self%snapshot_opening, n, n_snapshots)) name = 'certificate/snapshot_opening'
      if (.not. is_matrix(self%row_opening, n, n_rows)) name = 'certificate/row_opening'
      if (.not. is_matrix(self%pattern_forces, n, size(self%pattern_forces, 2))) name = 'certificate/pattern_forces'
      if (.not. is_matrix(self%pattern_opening, n, size(self%pattern_forces, 2))) name = 'certificate/pattern_opening'
      if (size(self%anchors) /= n_motions .or. .not. are_indices(self%anchors, n)) name = 'certificate/anchors'
      if (.not. are_indices(self%lift%columns, n)) name = 'certificate/lift_columns'
      if (.not. is_matrix(reshape(self%lift%values, [size(self%lift%values), 1]), size(self%lift%columns), 1)) &
        name = 'certificate/lift_values'
      if (size(starts) /= n + 1) then
        name = 'certificate/lift_starts'
      else if (starts(1) /= 0 .or. starts(n + 1) /= size(self%lift%columns) .or. any(starts(2:) < starts(:n))) then
        name = 'certificate/lift_starts'
      end if
    end associate
  end function mismatch

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(lifted_data_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/free_opening', self%free_opening, length, &
      'openings of all contacts without contact forces, a term per row')
    call file%write(group // '/snapshot_opening', self%snapshot_opening, length, &
      'what the forces of the snapshots open, a snapshot per row')
    call file%write(group // '/row_opening', self%row_opening, length // '/(' // force // ')', &
      'what a unit force on each contact row opens, a row per row')
    call file%write(group // '/pattern_forces', self%pattern_forces, force, 'force patterns of energy 1, a pattern per row')
    call file%write(group // '/pattern_opening', self%pattern_opening, length, 'openings that these patterns cause, a ' // &
      'pattern per row')
    call file%write(group // '/anchors', self%anchors, description= &
      'contact rows (1-based) whose forces balance the force patterns on bodies that only contact holds')
    call file%write(group // '/lift_starts', self%lift%starts, description='entries of contact i: starts(i) + 1 ... starts(i + 1)')
    call file%write(group // '/lift_columns', self%lift%columns, description='contact rows (1-based) of the entries')
    call file%write(group // '/lift_values', self%lift%values, force // '/' // length, &
      'stiffness against an opening of each contact by its own nodes alone')
    call file%write(group // '@largest_size', self%largest_size)
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset or attribute is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(lifted_data_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/free_opening', self%free_opening, error)
    call file%read(group // '/snapshot_opening', self%snapshot_opening, error)
    call file%read(group // '/row_opening', self%row_opening, error)
    call file%read(group // '/pattern_forces', self%pattern_forces, error)
    call file%read(group // '/pattern_opening', self%pattern_opening, error)
    call file%read(group // '/anchors', self%anchors, error)
    call file%read(group // '/lift_starts', self%lift%starts, error)
    call file%read(group // '/lift_columns', self%lift%columns, error)
    call file%read(group // '/lift_values', self%lift%values, error)
    call file%read(group // '@largest_size', self%largest_size, error)
  end subroutine read
end module sig_lifted_data
