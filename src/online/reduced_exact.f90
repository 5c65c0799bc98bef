! SPDX-License-Identifier: BSD-3-Clause
!> Common parts of the kinds of reduced model that solve for the exact forces on all contacts.
module sig_reduced_exact
  use sig_answer, only: answer_t
  use sig_bits, only: n_words
  use sig_dense_kernels, only: add_few_columns
  use sig_errors, only: error_t
  use sig_free_motions, only: anchor_work, count_free_motions
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_missing_parts, only: fill_missing
  use sig_reduced, only: displacement_by_modes, displacement_exact, displacement_none, model_sizes_t, reduced_t, room_t
  use sig_rounding, only: rounding_of_data
  use sig_shape_checks, only: are_indices, is_ascending, place_in_ascending
  use sig_text, only: join, string_t
  implicit none(type, external)
  private
  public :: reduced_exact_t, count_free, displacement_text, round_work, take_forces

  !> reasons why differentiate_lcp finds no derivatives
  character(*), parameter, public :: not_unique = 'the contact forces have no derivative at this point: they ' // &
    'are not unique, or contacts that touch without a force leave no solution beside this point'
  character(*), parameter, public :: pushed = 'the contact forces have no derivative at this point: beside it, on the side of ' // &
    'this direction, the loads move a body that no contact force holds here'

  !> Base type of these kinds. Each kind has two types, each in a file of its own: the first extends this type by the data, which it
  !> completes, checks, writes and reads; the second extends the first by the queries.
  type, abstract, extends(reduced_t) :: reduced_exact_t
    !> dofs whose displacement under the forces of the answer is exact (in an interpolated part except for the interpolation),
    !> ascending, 1-based, shape (n_exact): those of all nodes, or of the boundaries that the deck names, or none
    integer, allocatable :: exact_dofs(:)
    !> boundaries that the deck names for these dofs; empty if they are those of all nodes, or if there are none
    type(string_t), allocatable :: exact_boundaries(:)
    !> active sets (z > 0) at the training points, as bits; shape (n_words(n_multipliers), n_points), or no columns
    integer, allocatable :: start_sets(:, :)
  contains
    procedure :: contact_rows
    procedure :: n_modes
    procedure :: fill_multipliers
    procedure :: is_exact
    procedure :: has_modes
    procedure :: has_displacement
    procedure :: has_whole_field
    procedure :: displacement_source
    procedure :: complete_shared
    procedure :: shared_mismatch
    procedure :: write_shared
    procedure :: read_shared
  end type reduced_exact_t

contains

  !> Returns the numbers 1, 2, ..., n_rows: the part gives the forces of all contact rows of the model.
  pure function contact_rows(self) result(numbers)
    class(reduced_exact_t), intent(in) :: self
    integer, allocatable :: numbers(:)
    integer :: i

    numbers = [(i, i=1, self%n_rows())]
  end function contact_rows

  !> Returns 0: an answer has no coordinates of modes. This holds for a condensed part with modes, too, whose coordinates follow
  !> from the forces. An interpolated part returns the number of its modes instead.
  pure integer function n_modes(self)
    class(reduced_exact_t), intent(in) :: self

    n_modes = 0
  end function n_modes

  !> Copies the forces of all contacts from the answer, which has them already; `room` is not used.
  subroutine fill_multipliers(self, answer, room, multipliers)
    class(reduced_exact_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    class(room_t), intent(inout) :: room
    real(rk), intent(out) :: multipliers(:)

    multipliers = answer%multipliers
  end subroutine fill_multipliers

  !> Returns true: the forces are those of all contacts, without reconstruction.
  pure logical function is_exact(self)
    class(reduced_exact_t), intent(in) :: self

    is_exact = .true.
  end function is_exact

  !> Whether modes give the displacement of the dofs that are not exact. This default says no.
  pure logical function has_modes(self)
    class(reduced_exact_t), intent(in) :: self

    has_modes = .false.
  end function has_modes

  !> Whether the part has a displacement, perhaps of some dofs only.
  pure logical function has_displacement(self)
    class(reduced_exact_t), intent(in) :: self

    has_displacement = self%has_modes() .or. size(self%exact_dofs) > 0
  end function has_displacement

  !> Whether the part has a displacement of all dofs.
  pure logical function has_whole_field(self, n_dofs)
    class(reduced_exact_t), intent(in) :: self
    !> number of dofs of the model
    integer, intent(in) :: n_dofs

    has_whole_field = self%has_modes() .or. size(self%exact_dofs) == n_dofs
  end function has_whole_field

  !> Returns the source of a dof's displacement: displacement_exact, displacement_by_modes or displacement_none.
  pure integer function displacement_source(self, dof) result(source)
    class(reduced_exact_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: dof

    source = merge(displacement_by_modes, displacement_none, self%has_modes())
    if (place_in_ascending(self%exact_dofs, dof) > 0) source = displacement_exact
  end function displacement_source

  !> Allocates with size 0 each array of this base type that is not allocated.
  pure subroutine complete_shared(self, sizes)
    class(reduced_exact_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call fill_missing(self%exact_dofs)
    call fill_missing(self%exact_boundaries)
    call fill_missing(self%start_sets, n_words(sizes%n_multipliers))
  end subroutine complete_shared

  !> Returns the name of an array of this base type whose shape or values do not fit the model; empty when all fit. Requires:
  !> complete_shared.
  pure function shared_mismatch(self, sizes) result(name)
    class(reduced_exact_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = ''
    if (.not. (are_indices(self%exact_dofs, sizes%n_dofs) .and. is_ascending(self%exact_dofs))) name = 'exact_dofs'
    if (size(self%start_sets, 1) /= n_words(sizes%n_multipliers)) name = 'start_sets'
    if (size(self%start_sets, 2) > 0 .and. size(self%start_sets, 2) /= sizes%n_points) name = 'start_sets'
  end function shared_mismatch

  !> Writes the arrays of this base type to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write_shared(self, file, group)
    class(reduced_exact_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group

    call file%write(group // '/exact_dofs', self%exact_dofs, description='dofs whose displacement is exact, 1-based')
    call file%write(group // '/exact_boundaries', self%exact_boundaries, description= &
      'boundaries that have these dofs; empty: the dofs are those of all nodes, or there are none')
    call file%write(group // '/start_sets', self%start_sets, description= &
      'active contacts (of anchors: open ones) at each training point, a bit per contact, 32 to an integer, a point per row')
  end subroutine write_shared

  !> Reads the arrays of this base type from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read_shared(self, file, group, error)
    class(reduced_exact_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/exact_dofs', self%exact_dofs, error)
    call file%read(group // '/exact_boundaries', self%exact_boundaries, error)
    call file%read(group // '/start_sets', self%start_sets, error)
  end subroutine read_shared

  !> Computes the multipliers from the unknowns z of a condensed problem, and w = W z + q. For an anchor the unknown is its opening
  !> over `scale` instead of its multiplier, and w is its multiplier times `scale` instead of its opening.
  subroutine take_forces(compliance, free_opening, anchors, scale, opening, answer)
    !> [length/force] W, shape (n_multipliers, n_multipliers)
    real(rk), contiguous, intent(in) :: compliance(:, :)
    !> [length] q, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: free_opening(:)
    !> rows that are anchors, 1-based among the multipliers
    integer, intent(in) :: anchors(:)
    !> [length/force]
    real(rk), intent(in) :: scale
    !> [length] out: w, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    !> in: unknowns, [force] z; out: multipliers
    type(answer_t), intent(inout) :: answer
    integer :: i

    opening = free_opening
    call add_few_columns(compliance, answer%unknowns, opening)
    answer%multipliers = answer%unknowns
    do i = 1, size(anchors)
      associate (row => anchors(i))
        answer%multipliers(row) = merge(0.0_rk, max(0.0_rk, opening(row)) / scale, answer%unknowns(row) > 0)
      end associate
    end do
  end subroutine take_forces

  !> Counts the motions that no force holds (n_free_motions).
  subroutine count_free(compliance, anchors, scale, answer)
    !> [length/force] W, shape (n_multipliers, n_multipliers)
    real(rk), contiguous, intent(in) :: compliance(:, :)
    !> rows that are anchors, 1-based among the multipliers
    integer, intent(in) :: anchors(:)
    !> [length/force]
    real(rk), intent(in) :: scale
    !> in: multipliers, 0 where they are only rounding
    type(answer_t), intent(inout) :: answer

    answer%n_free_motions = 0
    if (size(anchors) == 0) return
    answer%n_free_motions = count_free_motions(anchor_work(compliance, anchors, scale), answer%multipliers)
  end subroutine count_free

  !> Sets changes of the work of the loads on the motions of the anchors to zero if they are rounding beside their terms, which are
  !> differences.
  pure subroutine round_work(anchors, terms, changes)
    !> 1-based among the rows
    integer, intent(in) :: anchors(:)
    !> sum of the absolute values of the terms of the changes at each anchor, shape (n_anchors, n_parameters)
    real(rk), intent(in) :: terms(:, :)
    !> changes of W z + q, shape (n_multipliers, n_parameters)
    real(rk), intent(inout) :: changes(:, :)
    integer :: i

    do i = 1, size(anchors)
      where (abs(changes(anchors(i), :)) <= rounding_of_data * terms(i, :)) changes(anchors(i), :) = 0
    end do
  end subroutine round_work

  !> Returns a text that says at which nodes a part has displacements, and how. It has no line end.
  pure function displacement_text(exact_boundaries, n_exact, elsewhere) result(text)
    !> boundaries at whose nodes displacements are exact; empty if this holds at all nodes or at none
    type(string_t), intent(in) :: exact_boundaries(:)
    !> number of dofs whose displacement is exact
    integer, intent(in) :: n_exact
    !> how the displacement of the other dofs is found, such as `by 12 modes`; empty if there is none
    character(*), intent(in) :: elsewhere
    character(:), allocatable :: text

    text = 'none: contact forces only'
    if (size(exact_boundaries) > 0) then
      text = 'exact at the nodes of ' // join(exact_boundaries, ', ')
    else if (n_exact > 0) then
      text = 'exact at all nodes'
    end if
    if (elsewhere /= '' .and. n_exact > 0) then
      text = text // ', ' // elsewhere // ' elsewhere'
    else if (elsewhere /= '') then
      text = elsewhere
    else if (size(exact_boundaries) > 0) then
      text = text // ', none elsewhere'
    end if
  end function displacement_text
end module sig_reduced_exact
