! SPDX-License-Identifier: BSD-3-Clause
!> Finds the values of a deck that `signorom init` could not know and that the user still has to fill in.
module sig_deck_unfilled
  use sig_deck_tree, only: deck_tree_t, kind_scalar
  implicit none(type, external)
  private
  public :: report_unfilled

  !> text in place of a missing value
  character(*), parameter, public :: placeholder = 'FILL_IN'

contains

  !> Reports an error for each value of the deck that is still the placeholder FILL_IN.
  subroutine report_unfilled(tree)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    integer :: i

    do i = 1, size(tree%nodes)
      if (tree%nodes(i)%kind /= kind_scalar) cycle
      if (tree%nodes(i)%text == placeholder) call tree%report(i, 'is not filled in yet')
    end do
  end subroutine report_unfilled
end module sig_deck_unfilled
