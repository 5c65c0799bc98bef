! SPDX-License-Identifier: BSD-3-Clause
!> Divides a line of a CSV file into its fields.
module sig_csv_fields
  use sig_text, only: join, split, string_t
  implicit none(type, external)
  private
  public :: split_fields, without_end

  !> stands for a comma between quotes while a line is divided; it occurs in no text file
  character(*), parameter :: hidden_comma = achar(0)

contains

  !> Returns the texts between the commas, without blanks around them, and the column of the first character of each; for an empty
  !> text the column behind the comma before it. Double quotes around a whole text are left out (RFC 4180): commas between them do
  !> not separate, and two quotes stand for one. Texts whose quotes do not match keep them.
  pure subroutine split_fields(line, fields, starts)
    character(*), intent(in) :: line
    type(string_t), allocatable, intent(out) :: fields(:)
    !> 1-based
    integer, allocatable, intent(out) :: starts(:)
    integer :: i_field, n_before

    fields = split(with_hidden_commas(without_end(line)), ',')
    allocate (starts(size(fields)))
    n_before = 0
    do i_field = 1, size(fields)
      starts(i_field) = n_before + max(1, verify(fields(i_field)%text, ' '))
      n_before = n_before + len(fields(i_field)%text) + 1
      fields(i_field)%text = unquoted(trim(adjustl(fields(i_field)%text)))
    end do
  end subroutine split_fields

  !> Returns the line with hidden_comma for each comma between double quotes. Quotes count only in a text that begins with one.
  pure function with_hidden_commas(line) result(text)
    character(*), intent(in) :: line
    character(:), allocatable :: text
    integer :: i
    logical :: has_begun, has_quotes, is_inside

    text = line
    if (index(line, '"') == 0) return
    has_begun = .false.
    has_quotes = .false.
    is_inside = .false.
    do i = 1, len(line)
      if (.not. has_begun) has_quotes = line(i:i) == '"'
      if (has_quotes .and. line(i:i) == '"') is_inside = .not. is_inside
      if (line(i:i) == ',' .and. is_inside) text(i:i) = hidden_comma
      has_begun = line(i:i) /= ' ' .or. has_begun
      if (line(i:i) == ',' .and. .not. is_inside) has_begun = .false.
    end do
  end function with_hidden_commas

  !> Returns the text with its hidden commas as commas and without the double quotes around it. Blanks just inside of these quotes
  !> are left out, and two quotes between them become one. A text whose quotes do not match keeps them. Requires: no blanks around
  !> the text.
  pure function unquoted(text) result(bare)
    character(*), intent(in) :: text
    character(:), allocatable :: bare
    type(string_t), allocatable :: pieces(:)
    integer :: i

    bare = text
    if (index(text, '"') /= 1) return
    bare = join(split(text, hidden_comma), ',')
    if (len(bare) == 1 .or. bare(len(bare):) /= '"') return
    pieces = split(bare(2:len(bare) - 1), '""')
    do i = 1, size(pieces)
      if (index(pieces(i)%text, '"') > 0) return
    end do
    bare = trim(adjustl(join(pieces, '"')))
  end function unquoted

  !> Returns the line without the carriage return at its end, which files from Windows have.
  pure function without_end(line) result(text)
    character(*), intent(in) :: line
    character(:), allocatable :: text

    text = line
    if (len(text) == 0) return
    if (text(len(text):) == achar(13)) text = text(:len(text) - 1)
  end function without_end
end module sig_csv_fields
