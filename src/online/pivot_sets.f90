! SPDX-License-Identifier: BSD-3-Clause
!> Principal pivot transforms of a fixed W for the active sets of some training points, the references. In the transformed problem
!> only contacts whose status differs from the reference have an unknown that is not zero, so that few of them cost work.
module sig_pivot_sets
  use sig_bits, only: unpack_bits
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_lcp, only: change_sets, lcp_solution_t, lcp_workspace_t
  use sig_linear_algebra, only: multiply
  use sig_missing_parts, only: fill_missing
  use sig_pivot_transform, only: transform_columns
  use sig_shape_checks, only: are_indices, is_matrix
  implicit none(type, external)
  private
  public :: pivot_sets_t, transform_scale

  type :: pivot_sets_t
    !> training points whose active sets have a principal pivot transform, shape (n_references)
    integer, allocatable :: reference_points(:)
    !> number of the reference nearest to each training point's set, 1-based; shape (n_points), or none
    integer, allocatable :: reference_of_point(:)
    !> the transforms of W / transform_scale side by side, shape (n_rows, n_rows * n_references)
    real(rk), allocatable :: transforms(:, :)
    !> [force per unit of theta] q / transform_scale of each transform; shape (n_rows, n_terms, n_references)
    real(rk), allocatable, private :: openings(:, :, :)
    !> active sets of the references, shape (n_rows, n_references)
    logical, allocatable, private :: sets(:, :)
  contains
    procedure :: complete
    procedure :: mismatch
    procedure :: prepare
    procedure :: reference_near
    procedure :: solve
    procedure :: clear
    procedure :: write
    procedure :: read
  end type pivot_sets_t

contains

  !> Allocates each array of the file that is not allocated, without references.
  pure subroutine complete(self, n_rows)
    class(pivot_sets_t), intent(inout) :: self
    integer, intent(in) :: n_rows

    call fill_missing(self%reference_points)
    call fill_missing(self%reference_of_point)
    call fill_missing(self%transforms, n_rows)
  end subroutine complete

  !> Returns the name of an array whose shape or values do not fit; empty when all fit. Requires: complete.
  pure function mismatch(self, n_rows, n_sets) result(name)
    class(pivot_sets_t), intent(in) :: self
    integer, intent(in) :: n_rows
    !> number of training points with an active set
    integer, intent(in) :: n_sets
    character(:), allocatable :: name

    name = ''
    associate (n_references => size(self%reference_points))
      if (.not. are_indices(self%reference_points, n_sets)) name = 'reference_points'
      if (n_references > 0 .and. size(self%reference_of_point) /= n_sets) name = 'reference_of_point'
      if (.not. are_indices(self%reference_of_point, n_references)) name = 'reference_of_point'
      if (.not. is_matrix(self%transforms, n_rows, n_rows * n_references)) name = 'transforms'
    end associate
  end function mismatch

  !> Removes all references.
  pure subroutine clear(self)
    class(pivot_sets_t), intent(inout) :: self

    self%reference_points = [integer ::]
    self%reference_of_point = [integer ::]
    self%transforms = self%transforms(:, :0)
  end subroutine clear

  !> Returns the compliance [length/force], the largest entry of W, by which W and q are divided before they are transformed. A
  !> transformed problem has forces and openings as unknowns; over a compliance these are forces, too, and what is small beside what
  !> does not depend on the units.
  pure real(rk) function transform_scale(matrix) result(scale)
    !> [length/force] W
    real(rk), intent(in) :: matrix(:, :)

    scale = max(0.0_rk, maxval(abs(matrix)))
    if (.not. scale > 0) scale = 1
  end function transform_scale

  !> Transforms the terms of q for each reference.
  subroutine prepare(self, scale, free_opening, start_sets)
    class(pivot_sets_t), intent(inout) :: self
    !> [length/force] result of transform_scale
    real(rk), intent(in) :: scale
    !> [length per unit of theta] the terms of q, shape (n_rows, n_terms)
    real(rk), intent(in) :: free_opening(:, :)
    !> active sets of the training points as bits, shape (n_words, n_points)
    integer, intent(in) :: start_sets(:, :)
    integer :: i, n

    n = size(free_opening, 1)
    if (allocated(self%openings)) deallocate (self%openings, self%sets)
    associate (points => self%reference_points)
      allocate (self%openings(n, size(free_opening, 2), size(points)), self%sets(n, size(points)))
      do i = 1, size(points)
        call unpack_bits(start_sets(:, points(i)), self%sets(:, i))
        self%openings(:, :, i) = free_opening / scale
        call transform_columns(self%transforms(:, (i - 1) * n + 1:i * n), self%sets(:, i), self%openings(:, :, i))
      end do
    end associate
  end subroutine prepare

  !> Returns the number of the reference for a query near a training point, 1-based; 0: there is none.
  pure integer function reference_near(self, nearest) result(i_reference)
    class(pivot_sets_t), intent(in) :: self
    !> number of the training point, 1-based; 0: none
    integer, intent(in) :: nearest

    i_reference = 0
    if (nearest >= 1 .and. nearest <= size(self%reference_of_point)) i_reference = self%reference_of_point(nearest)
  end function reference_near

  !> Solves the problem by the pivot transform of a reference and the active set method alone (change_sets). Only contacts whose
  !> status differs from the reference cost work. Without an answer (solution%reason < 0) the unknowns do not change.
  subroutine solve(self, i_reference, theta, start, opening, solution, workspace, unknowns)
    class(pivot_sets_t), intent(in) :: self
    !> number of the reference, 1-based
    integer, intent(in) :: i_reference
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> active set to start from, shape (n_rows); for a while its difference to the reference
    logical, contiguous, intent(inout) :: start(:)
    !> [force] work array, shape (n_rows)
    real(rk), contiguous, intent(inout) :: opening(:)
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    !> [force] z of the problem before the transform, shape (n_rows)
    real(rk), intent(inout) :: unknowns(:)
    integer :: i, n

    n = size(opening)
    call multiply(1.0_rk, self%openings(:, :, i_reference), theta, 0.0_rk, opening)
    associate (in_reference => self%sets(:, i_reference))
      start = start .neqv. in_reference
      call change_sets(self%transforms(:, (i_reference - 1) * n + 1:i_reference * n), opening, start, solution, workspace)
      start = start .neqv. in_reference
      if (solution%reason < 0) return
      do i = 1, n
        unknowns(i) = solution%lambda(i)
        if (in_reference(i)) unknowns(i) = merge(0.0_rk, max(0.0_rk, workspace%w(i)), solution%lambda(i) > 0)
      end do
    end associate
  end subroutine solve

  !> Writes the references to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group)
    class(pivot_sets_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group

    call file%write(group // '/reference_points', self%reference_points, description= &
      'training points whose active sets have a pivot transform, 1-based')
    call file%write(group // '/reference_of_point', self%reference_of_point, description= &
      'of each training point: the reference (1-based) whose active set is nearest to its own')
    call file%write(group // '/transforms', self%transforms, description= &
      'principal pivot transforms of compliance over its largest entry, transposed, one below another')
  end subroutine write

  !> Reads the references from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(pivot_sets_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/reference_points', self%reference_points, error)
    call file%read(group // '/reference_of_point', self%reference_of_point, error)
    call file%read(group // '/transforms', self%transforms, error)
  end subroutine read
end module sig_pivot_sets
