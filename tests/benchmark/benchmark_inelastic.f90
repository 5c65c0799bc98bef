! SPDX-License-Identifier: BSD-3-Clause
!> Times of queries of a model of materials that flow: with strains at all points, with the correction of the forces alone, and
!> without the correction.
!>
!> Arguments: model.h5, values of the parameters of each history, one history after the other.
program benchmark_inelastic
  use sig_answer, only: answer_t
  use sig_errors, only: error_report, error_t
  use sig_flow_points, only: flow_points_t
  use sig_history, only: states_of
  use sig_inelastic_model, only: inelastic_model_t
  use sig_kinds, only: rk
  use sig_model_file, only: read_model
  use sig_online_model, only: online_model_t
  use sig_query, only: query_t
  implicit none(type, external)

  !> all histories are asked so often, and the shortest time counts
  integer, parameter :: n_repeats = 2
  character(1024) :: argument
  character(:), allocatable :: message
  type(online_model_t) :: online
  type(error_t), allocatable :: error
  real(rk), allocatable :: parameters(:), states(:, :)
  integer :: i, i_bad_point

  call get_command_argument(1, argument)
  call read_model(trim(argument), online%model, error)
  if (allocated(error)) error stop error_report(error)
  call online%prepare(message)
  if (allocated(message)) error stop message
  allocate (parameters(command_argument_count() - 1))
  do i = 1, size(parameters)
    call get_command_argument(1 + i, argument)
    read (argument, *) parameters(i)
  end do
  associate (model => online%model)
    associate (n => model%n_given())
      call states_of(model%history, model%parameter_names(:n), reshape(parameters, [n, size(parameters) / n]), states, &
        i_bad_point, message)
    end associate
    if (allocated(message)) error stop message
    select type (part => model%parts(1)%reduced)
    type is (inelastic_model_t)
      print '(a, 6(i0, 1x))', 'rows, modes, points, of them chosen, for the correction; times: ', part%n_rows(), part%n_modes(), &
        part%all%n_points(), part%chosen%n_points(), part%check%n_points(), size(states, 2)
      call ask('with points', .true.)
      call ask('corrected', .false.)
      part%check = flow_points_t()
      call part%check%complete(model%terms%n_terms(), part%n_rows(), part%n_modes())
      call ask('raw', .false.)
    class default
      error stop 'the materials of the model do not flow'
    end select
  end associate

contains

  !> Asks all histories, and says what a time takes on average, the largest plastic or creep strain, and what half of the times take
  !> at most.
  subroutine ask(name, has_points)
    character(*), intent(in) :: name
    !> whether answers have the strains at all points
    logical, intent(in) :: has_points
    type(query_t) :: query
    type(answer_t) :: answer
    character(:), allocatable :: message
    real(rk) :: finish, largest, last, shortest, start
    real(rk) :: times(size(states, 2))
    integer :: i, i_repeat, n_iterations, n_refused

    call query%create(online, message)
    if (allocated(message)) error stop message
    if (.not. has_points) call query%leave_out_points()
    largest = 0
    shortest = huge(shortest)
    do i_repeat = 1, n_repeats
      n_iterations = 0
      n_refused = 0
      call cpu_time(start)
      last = start
      do i = 1, size(states, 2)
        call query%continue(online, states(:, i), answer)
        n_iterations = n_iterations + answer%n_iterations
        if (answer%reason <= 0) n_refused = n_refused + 1
        if (allocated(answer%plastic)) largest = max(largest, maxval(answer%plastic))
        if (allocated(answer%creep)) largest = max(largest, maxval(answer%creep))
        call cpu_time(finish)
        times(i) = finish - last
        last = finish
      end do
      call query%end_history()
      shortest = min(shortest, finish - start)
    end do
    call query%destroy()
    print '(a, 2(1x, es12.5), 1x, i0, 2(1x, es12.5))', name // &
      ', seconds and iterations per time, without answer, largest strain, median seconds: ', &
      shortest / size(states, 2), real(n_iterations, rk) / size(states, 2), n_refused, largest, median_of(times)
  end subroutine ask

  !> Returns the number in the middle; 0 without numbers.
  pure real(rk) function median_of(numbers)
    real(rk), intent(in) :: numbers(:)
    real(rk) :: rest(size(numbers))
    integer :: i

    rest = numbers
    do i = 1, (size(rest) - 1) / 2
      rest(maxloc(rest, dim=1)) = -huge(rest)
    end do
    median_of = max(0.0_rk, maxval(rest))
  end function median_of
end program benchmark_inelastic
