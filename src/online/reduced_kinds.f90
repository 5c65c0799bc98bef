! SPDX-License-Identifier: BSD-3-Clause
!> The kinds of reduced models by their names: a new kind needs a file of its own and a line here.
module sig_reduced_kinds
  use sig_reduced, only: reduced_t
  use sig_reduced_condensed, only: reduced_condensed_t
  use sig_reduced_hhr, only: reduced_hhr_t
  use sig_reduced_interpolated, only: reduced_interpolated_t
  use sig_reduced_tied, only: reduced_tied_t
  implicit none(type, external)
  private
  public :: create_reduced

  character(*), parameter, public :: kind_names = 'condensed, hhr, interpolated, tied'

contains

  !> Makes a reduced model without data, of the kind with this name (kind_names); it stays unallocated if the name is unknown.
  subroutine create_reduced(kind, reduced)
    character(*), intent(in) :: kind
    class(reduced_t), allocatable, intent(out) :: reduced

    select case (kind)
    case ('condensed')
      allocate (reduced_condensed_t :: reduced)
    case ('hhr')
      allocate (reduced_hhr_t :: reduced)
    case ('interpolated')
      allocate (reduced_interpolated_t :: reduced)
    case ('tied')
      allocate (reduced_tied_t :: reduced)
    case default
      return
    end select
  end subroutine create_reduced
end module sig_reduced_kinds
