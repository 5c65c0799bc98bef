! SPDX-License-Identifier: BSD-3-Clause
!> What the kinds of reduced model share that solve for the exact forces on all contacts.
module sig_reduced_exact
  use sig_answer, only: answer_t
  use sig_dense_kernels, only: add_few_columns
  use sig_kinds, only: rk
  use sig_reduced, only: reduced_t, room_t
  use sig_text, only: counted, join, string_t
  implicit none(type, external)
  private
  public :: reduced_exact_t, displacement_text, take_forces

  character(*), parameter, public :: not_unique = 'the contact forces have no derivative at this point: they are not unique'

  type, abstract, extends(reduced_t) :: reduced_exact_t
  contains
    procedure :: contact_rows
    procedure :: n_modes
    procedure :: fill_multipliers
    procedure :: is_exact
  end type reduced_exact_t

contains

  !> The contact rows that the part solves for: all of the model.
  pure function contact_rows(self) result(numbers)
    class(reduced_exact_t), intent(in) :: self
    integer, allocatable :: numbers(:)
    integer :: i

    numbers = [(i, i=1, self%n_rows())]
  end function contact_rows

  !> There is no basis that the forces depend on.
  pure integer function n_modes(self)
    class(reduced_exact_t), intent(in) :: self

    n_modes = 0
  end function n_modes

  subroutine fill_multipliers(self, answer, room, multipliers)
    class(reduced_exact_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    class(room_t), intent(inout) :: room
    real(rk), intent(out) :: multipliers(:)

    multipliers = answer%multipliers
  end subroutine fill_multipliers

  pure logical function is_exact(self)
    class(reduced_exact_t), intent(in) :: self

    is_exact = .true.
  end function is_exact

  !> Multipliers from the unknowns of a condensed problem, and the openings w = W z + q. In the place of an anchor's multiplier
  !> stands its opening, in the place of its opening its multiplier times `scale`.
  subroutine take_forces(compliance, free_opening, anchors, scale, opening, answer)
    !> [length/force] W, shape (n_multipliers, n_multipliers)
    real(rk), contiguous, intent(in) :: compliance(:, :)
    !> [length] q
    real(rk), contiguous, intent(in) :: free_opening(:)
    !> 1-based among the multipliers
    integer, intent(in) :: anchors(:)
    !> [length/force]
    real(rk), intent(in) :: scale
    !> [length] w, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    !> unknowns are set
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
    call answer%take_all_forces()
  end subroutine take_forces

  !> Says of which dofs a model has displacements, and whether they are exact.
  pure function displacement_text(exact_boundaries, n_exact, n_modes) result(text)
    !> boundaries whose nodes are exact; none where all nodes are, or no node
    type(string_t), intent(in) :: exact_boundaries(:)
    !> dofs whose displacement is exact
    integer, intent(in) :: n_exact
    !> modes for the others
    integer, intent(in) :: n_modes
    character(:), allocatable :: text

    text = 'none: contact forces only'
    if (size(exact_boundaries) > 0) then
      text = 'exact at the nodes of ' // join(exact_boundaries, ', ')
    else if (n_exact > 0) then
      text = 'exact at all nodes'
    end if
    if (n_modes > 0 .and. n_exact > 0) then
      text = text // ', by ' // counted(n_modes, 'mode') // ' elsewhere'
    else if (n_modes > 0) then
      text = 'by ' // counted(n_modes, 'mode')
    else if (size(exact_boundaries) > 0) then
      text = text // ', none elsewhere'
    end if
  end function displacement_text
end module sig_reduced_exact
