! SPDX-License-Identifier: BSD-3-Clause
!> The contact force at a point, in Fortran: ask_model_f MODEL VALUE...
program ask_model
  use, intrinsic :: iso_c_binding, only: c_double, c_null_char, c_ptr, c_sizeof
  use signorom, only: SIGNOROM_OK, signorom_answer, signorom_arrays, signorom_close, signorom_create_context, &
    signorom_free_context, &
    signorom_get_multipliers, signorom_get_parameter, signorom_get_sizes, signorom_message, signorom_model_message, &
    signorom_open, signorom_query, signorom_sizes, signorom_string, signorom_version
  implicit none(type, external)
  type(c_ptr) :: model, context, name
  type(signorom_sizes) :: sizes
  type(signorom_answer) :: answer
  type(signorom_arrays) :: arrays
  real(c_double), allocatable :: point(:), forces(:)
  real(c_double) :: smallest
  integer :: i

  if (c_sizeof(answer) /= answer%size) error stop 'the structure signorom_answer has another size than in C'
  if (c_sizeof(arrays) /= arrays%size) error stop 'the structure signorom_arrays has another size than in C'
  if (signorom_open(argument(1) // c_null_char, model) /= SIGNOROM_OK) call fail(signorom_model_message(model))
  if (signorom_get_sizes(model, sizes) /= SIGNOROM_OK) error stop 1
  allocate (point(sizes%n_parameters), forces(sizes%n_contacts))
  do i = 1, size(point)
    call read_value(argument(i + 1), point(i))
    if (signorom_get_parameter(model, i - 1, name=name, minimum=smallest) /= SIGNOROM_OK) error stop 1
    print '(a, " from ", g0)', signorom_string(name), smallest
  end do
  if (signorom_create_context(model, context) /= SIGNOROM_OK) call fail(signorom_message(context))
  if (signorom_query(context, point, answer) /= SIGNOROM_OK) call fail(signorom_message(context))
  if (signorom_get_multipliers(context, forces) /= SIGNOROM_OK) call fail(signorom_message(context))
  print '("signorom ", a, ": contact force ", es19.12)', signorom_string(signorom_version()), sum(forces)
  print '("error of the displacement ", es19.12)', answer%relative_displacement_bound
  call signorom_free_context(context)
  call signorom_close(model)

contains

  function argument(i) result(word)
    integer, intent(in) :: i
    character(:), allocatable :: word
    integer :: n

    call get_command_argument(i, length=n)
    allocate (character(n) :: word)
    call get_command_argument(i, word)
  end function argument

  subroutine read_value(word, value)
    character(*), intent(in) :: word
    real(c_double), intent(out) :: value

    read (word, *) value
  end subroutine read_value

  subroutine fail(message)
    type(c_ptr), intent(in) :: message

    print '(a)', signorom_string(message)
    stop 2
  end subroutine fail
end program ask_model
