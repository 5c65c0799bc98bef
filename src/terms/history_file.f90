! SPDX-License-Identifier: BSD-3-Clause
!> Reads, writes and checks the history of a model in model.h5: times of the states, and the texts of the tables.
module sig_history_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_history, only: history_t, table_values_t, time_name
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: history_fits, read_history, write_history

contains

  !> Writes the history into a group of an open file; nothing without a history. A failure of the file is reported when the file is
  !> closed.
  subroutine write_history(file, group, history)
    type(h5_writer_t), intent(inout) :: file
    !> path of the group in the file
    character(*), intent(in) :: group
    type(history_t), intent(in) :: history
    integer :: i

    if (.not. history%is_there()) return
    call file%write(group // '/times', history%times, history%unit, 'times of the states of a history')
    call file%write(group // '/unit', history%unit)
    call file%write(group // '@n_tables', size(history%tables))
    do i = 1, size(history%tables)
      associate (table => history%tables(i), place => group // '/tables/' // to_text(i))
        call file%write(place // '/name', table%name)
        call file%write(place // '/times', table%times, description='times of the nodes: numbers or expressions of the parameters')
        call file%write(place // '/values', table%values, description='values there, likewise; linear in between')
      end associate
    end do
  end subroutine write_history

  !> Reads the history of a model; without the group there is none. If `error` is allocated before, nothing is read. Errors: a
  !> dataset or an attribute is missing, or has another type or rank.
  subroutine read_history(file, group, history, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(history_t), intent(out) :: history
    type(error_t), allocatable, intent(inout) :: error
    integer :: i, n_tables

    history%unit = ''
    allocate (history%times(0), history%tables(0))
    if (.not. file%has(group)) return
    call file%read(group // '/times', history%times, error)
    call file%read(group // '/unit', history%unit, error)
    call file%read(group // '@n_tables', n_tables, error)
    if (allocated(error)) return
    deallocate (history%tables)
    ! a number in the file may have any value
    allocate (history%tables(file%count_groups(group // '/tables', max(0, n_tables))))
    do i = 1, size(history%tables)
      associate (table => history%tables(i), place => group // '/tables/' // to_text(i))
        call file%read(place // '/name', table%name, error)
        call file%read(place // '/times', table%times, error)
        call file%read(place // '/values', table%values, error)
      end associate
    end do
  end subroutine read_history

  !> Whether the times are finite and ascend from above 0, each table has as many times as values, at least one, and all texts are
  !> numbers or expressions of the parameters; and whether the names of a state are those of the parameters, `time` and the tables.
  logical function history_fits(history, state_names) result(fits)
    type(history_t), intent(in) :: history
    type(string_t), intent(in) :: state_names(:)
    type(table_values_t) :: tables
    character(:), allocatable :: message
    integer :: i, n

    fits = .true.
    if (.not. history%is_there()) return
    n = size(state_names) - history%n_values()
    fits = n >= 1 .and. all(ieee_is_finite(history%times)) .and. history%times(1) > 0 .and. &
      all(history%times(2:) > history%times(:size(history%times) - 1))
    if (fits) fits = state_names(n + 1)%text == time_name
    do i = 1, size(history%tables)
      associate (table => history%tables(i))
        if (fits) fits = size(table%times) > 0 .and. size(table%times) == size(table%values) .and. &
          state_names(n + 1 + i)%text == table%name
      end associate
    end do
    if (.not. fits) return
    call tables%create(history, state_names(:n), message)
    fits = .not. allocated(message)
    call tables%destroy()
  end function history_fits
end module sig_history_file
