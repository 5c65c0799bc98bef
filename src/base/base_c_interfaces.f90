! SPDX-License-Identifier: BSD-3-Clause
!> The C side of this layer, as declared in include/signorom/{memory,number_text,random_numbers,shell,signals,system,threads}.h.
module sig_base_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_funptr, c_int, c_int64_t, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: strlen, sig_random_below, sig_random_fraction, sig_install_stop_signals, sig_is_stop_requested, &
    sig_set_last_words, sig_is_terminal, sig_run_shell, sig_memory_use, sig_begin_memory_watch, sig_end_memory_watch, &
    sig_need_memory, sig_error_text, sig_free, sig_write_all, sig_shortest_decimal, sig_run_threads, sig_processor_count, &
    sig_open_to_append, sig_terminal_columns, sig_machine_memory, &
    sig_return_large_blocks

  interface
    function sig_random_fraction(state) result(value) bind(c)
      import :: c_double, c_int64_t
      integer(c_int64_t), intent(inout) :: state
      real(c_double) :: value
    end function sig_random_fraction

    function sig_random_below(state, n) result(value) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), intent(inout) :: state
      integer(c_int), value :: n
      integer(c_int) :: value
    end function sig_random_below

    pure integer(c_size_t) function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function strlen

    subroutine sig_install_stop_signals(grace) bind(c)
      import :: c_double
      real(c_double), value :: grace
    end subroutine sig_install_stop_signals

    subroutine sig_set_last_words(text, length, descriptor) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value :: length
      integer(c_int), value :: descriptor
    end subroutine sig_set_last_words

    subroutine sig_memory_use(peak, limit) bind(c)
      import :: c_double
      real(c_double), intent(out) :: peak, limit
    end subroutine sig_memory_use

    function sig_machine_memory(root) result(n_bytes) bind(c)
      import :: c_char, c_double
      character(kind=c_char), intent(in) :: root(*)
      real(c_double) :: n_bytes
    end function sig_machine_memory

    subroutine sig_return_large_blocks() bind(c)
    end subroutine sig_return_large_blocks

    subroutine sig_begin_memory_watch() bind(c)
    end subroutine sig_begin_memory_watch

    subroutine sig_end_memory_watch() bind(c)
    end subroutine sig_end_memory_watch

    subroutine sig_need_memory(n_bytes) bind(c)
      import :: c_double
      real(c_double), value :: n_bytes
    end subroutine sig_need_memory

    integer(c_int) function sig_run_shell(command) bind(c)
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: command(*)
    end function sig_run_shell

    integer(c_int) function sig_is_stop_requested() bind(c)
      import :: c_int
    end function sig_is_stop_requested

    integer(c_int) function sig_is_terminal(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end function sig_is_terminal

    integer(c_int) function sig_open_to_append(path, length, descriptor) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(out) :: descriptor
    end function sig_open_to_append

    integer(c_int) function sig_terminal_columns(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end function sig_terminal_columns

    integer(c_int) function sig_write_all(descriptor, bytes, size) bind(c)
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
    end function sig_write_all

    subroutine sig_error_text(code, text, size) bind(c)
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: code
      character(kind=c_char), intent(inout) :: text(*)
      integer(c_size_t), value :: size
    end subroutine sig_error_text

    subroutine sig_free(block) bind(c)
      import :: c_ptr
      type(c_ptr), value :: block
    end subroutine sig_free

    pure subroutine sig_shortest_decimal(number, text, length) bind(c)
      import :: c_char, c_double, c_int
      real(c_double), value :: number
      character(kind=c_char), intent(inout) :: text(*)
      integer(c_int), intent(out) :: length
    end subroutine sig_shortest_decimal

    subroutine sig_run_threads(n, work, data) bind(c)
      import :: c_funptr, c_int, c_ptr
      integer(c_int), value :: n
      type(c_funptr), value :: work
      type(c_ptr), value :: data
    end subroutine sig_run_threads

    integer(c_int) function sig_processor_count() bind(c)
      import :: c_int
    end function sig_processor_count
  end interface
end module sig_base_c_interfaces
