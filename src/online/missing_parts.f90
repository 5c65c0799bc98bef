! SPDX-License-Identifier: BSD-3-Clause
!> Allocates texts and arrays of a model that are not allocated.
module sig_missing_parts
  use sig_kinds, only: rk
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: fill_missing

  !> Allocates an empty text, an array of size 0, or a matrix of n_rows rows and no columns, if it is not allocated yet.
  interface fill_missing
    procedure fill_text, fill_texts, fill_integers, fill_integer_matrix, fill_reals, fill_matrix
  end interface fill_missing

contains

  pure subroutine fill_text(text)
    character(:), allocatable, intent(inout) :: text

    if (.not. allocated(text)) text = ''
  end subroutine fill_text

  pure subroutine fill_texts(texts)
    type(string_t), allocatable, intent(inout) :: texts(:)

    if (.not. allocated(texts)) allocate (texts(0))
  end subroutine fill_texts

  pure subroutine fill_integers(values)
    integer, allocatable, intent(inout) :: values(:)

    if (.not. allocated(values)) allocate (values(0))
  end subroutine fill_integers

  pure subroutine fill_integer_matrix(values, n_rows)
    integer, allocatable, intent(inout) :: values(:, :)
    integer, intent(in) :: n_rows

    if (.not. allocated(values)) allocate (values(n_rows, 0))
  end subroutine fill_integer_matrix

  pure subroutine fill_reals(values)
    real(rk), allocatable, intent(inout) :: values(:)

    if (.not. allocated(values)) allocate (values(0))
  end subroutine fill_reals

  pure subroutine fill_matrix(values, n_rows)
    real(rk), allocatable, intent(inout) :: values(:, :)
    integer, intent(in) :: n_rows

    if (.not. allocated(values)) allocate (values(n_rows, 0))
  end subroutine fill_matrix
end module sig_missing_parts
