! SPDX-License-Identifier: BSD-3-Clause
!> usage: check_certificate MODEL N_POINTS SEED [CONDENSED_MODEL]
!>
!> Bounds of forces against their true error in the norm of W, at random points of a model: of its own answers, and of spoiled
!> ones (exact forces with 1 % noise, with one wrong status, with the edge of the contact off by three nodes). W is the model's own
!> or that of a condensed model of the same problem, whose W then also says what spoiled forces open. One line
!> each: kind, points, bounds below the error, effectivity (bound over error: median, 95 %, largest). Errors below 1e-10 of the
!> answer are rounding and have no effectivity. The exact forces come from W without the start of a query; with
!> more than 500 contacts the query says which are closed, and a factor of W on these what they bear. Where contact alone holds
!> bodies only answers have bounds, in the norm of their elastic displacements.
program check_certificate
  use, intrinsic :: iso_fortran_env, only: error_unit
  use sig_answer, only: answer_t
  use sig_condensed_model, only: condensed_model_t
  use sig_dense_kernels, only: factor_cholesky, solve_cholesky
  use sig_errors, only: error_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_kinds, only: rk
  use sig_lifted_certificate, only: lifted_certificate_t
  use sig_model_file, only: read_model
  use sig_online_model, only: online_model_t
  use sig_query, only: query_t
  use sig_random_numbers, only: random_t
  use sig_reasons, only: reason_linear_solver
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_reduced_hhr, only: reduced_hhr_t
  use sig_statistics, only: statistics_t, summarize
  implicit none(type, external)

  integer, parameter :: n_kinds = 4
  character(24), parameter :: kinds(n_kinds) = [character(24) :: 'answer', 'noise of 1 %', 'one wrong status', 'edge off by three']
  !> [-] of the answer's size: what rounding of w alone makes of a bound and of an error
  real(rk), parameter :: rounding = 1.0e-12_rk
  real(rk), parameter :: smallest_error = 1.0e-10_rk

  !> above this number of contacts the model says which are closed
  integer, parameter :: most_solved_anew = 500

  !> Effectivities of a kind, and bounds that are none.
  type :: record_t
    integer :: n_points = 0
    integer :: n_violations = 0
    real(rk), allocatable :: effectivities(:)
  end type record_t

  type(online_model_t), target :: online
  type(online_model_t), target :: condensed
  !> where W is
  type(online_model_t), pointer :: reference
  !> of clusters that have no W
  type(lifted_certificate_t), allocatable :: lifted(:)
  type(record_t) :: records(n_kinds)
  type(random_t) :: random
  integer :: i_exact, n_points, n_unanswered, n_unsolved

  call start()
  call check_points()
  call print_table()
  deallocate (lifted)

contains

  subroutine start()
    type(error_t), allocatable :: error
    character(:), allocatable :: message, text
    integer :: k

    text = argument(2)
    read (text, *) n_points
    text = argument(3)
    read (text, *) random%state
    call read_model(argument(1), online%model, error)
    if (allocated(error)) call give_up(error%message)
    call online%prepare(message)
    if (allocated(message)) call give_up(message)
    ! every answer stands, however large its bound
    online%model%max_error = huge(online%model%max_error)
    reference => online
    if (command_argument_count() > 3) then
      call read_model(argument(4), condensed%model, error)
      if (allocated(error)) call give_up(error%message)
      call condensed%prepare(message)
      if (allocated(message)) call give_up(message)
      reference => condensed
    end if
    i_exact = reference%model%fallback()
    if (i_exact == 0) i_exact = 1
    allocate (lifted(online%model%n_clusters()))
    do k = 1, size(lifted)
      select type (part => online%model%parts(k)%reduced)
      type is (reduced_hhr_t)
        call lifted(k)%prepare(part%data)
      end select
    end do
    do k = 1, n_kinds
      allocate (records(k)%effectivities(0))
    end do
  end subroutine start

  function argument(i) result(text)
    integer, intent(in) :: i
    character(:), allocatable :: text
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(length) :: text)
    call get_command_argument(i, text)
  end function argument

  subroutine give_up(message)
    character(*), intent(in) :: message

    write (error_unit, '(a)') message
    stop 2
  end subroutine give_up

  subroutine check_points()
    type(query_t) :: query
    type(answer_t) :: answer
    character(:), allocatable :: message
    real(rk) :: point(size(online%model%box, 2))
    integer :: i, k

    call query%create(online, message)
    if (allocated(message)) call give_up(message)
    n_unanswered = 0
    n_unsolved = 0
    do i = 1, n_points
      do k = 1, size(point)
        call random%fraction(point(k))
      end do
      point = online%model%box(1, :) + point * (online%model%box(2, :) - online%model%box(1, :))
      call query%evaluate(online, point, answer)
      if (answer%reason < 0) then
        n_unanswered = n_unanswered + 1
      else
        call check_answer(answer)
      end if
    end do
    call query%destroy()
  end subroutine check_points

  subroutine check_answer(answer)
    type(answer_t), intent(inout) :: answer
    class(room_t), allocatable :: room

    select type (part => reference%model%parts(i_exact)%reduced)
    type is (condensed_model_t)
      call part%create_room(room)
      select type (fixed => part%compliance)
      type is (fixed_compliance_t)
        call check_against(part, fixed, room, answer)
        return
      end select
    end select
    call give_up('the model has no operator of all contacts')
  end subroutine check_answer

  subroutine check_against(part, fixed, room, answer)
    type(condensed_model_t), intent(in) :: part
    !> its compliance
    type(fixed_compliance_t), intent(in) :: fixed
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    type(answer_t) :: exact

    exact = answer
    if (size(exact%multipliers) <= most_solved_anew) then
      call part%solve(answer%theta, neighbors_t(), room, exact)
    else
      call solve_on_closed(fixed, exact)
    end if
    if (exact%reason < 0) then
      n_unsolved = n_unsolved + 1
      return
    end if
    if (answer%bound >= 0) call compare(fixed, exact%multipliers, answer%multipliers, answer%bound, records(1))
    if (size(fixed%anchors) == 0) call check_spoiled(part, fixed, room, exact%multipliers, answer)
  end subroutine check_against

  !> Requires: no body that only contact holds.
  subroutine solve_on_closed(fixed, exact)
    type(fixed_compliance_t), intent(in) :: fixed
    !> in: forces of a query, and its terms
    type(answer_t), intent(inout) :: exact
    real(rk), allocatable :: factor(:, :), forces(:)
    integer, allocatable :: closed(:)
    integer :: i, info

    closed = pack([(i, i=1, size(exact%multipliers))], exact%multipliers > 0)
    factor = fixed%compliance(closed, closed)
    forces = -matmul(fixed%free_opening(closed, :), exact%theta)
    call factor_cholesky(size(closed), factor, info)
    if (info == 0) call solve_cholesky(size(closed), factor, forces)
    if (info /= 0 .or. any(forces < -rounding * maxval(abs(forces)))) then
      exact%reason = reason_linear_solver
    else
      exact%multipliers(closed) = max(forces, 0.0_rk)
    end if
  end subroutine solve_on_closed

  subroutine check_spoiled(part, fixed, room, exact, answer)
    type(condensed_model_t), intent(in) :: part
    type(fixed_compliance_t), intent(in) :: fixed
    class(room_t), intent(inout) :: room
    real(rk), intent(in) :: exact(:)
    type(answer_t), intent(inout) :: answer
    real(rk), allocatable :: spoiled(:)
    real(rk) :: bound
    integer :: k

    if (.not. any(exact > 0)) return
    do k = 2, n_kinds
      spoiled = spoil(exact, k)
      if (lifted(answer%cluster)%is_there) then
        bound = lifted(answer%cluster)%bound%evaluate(spoiled, matmul(fixed%compliance, spoiled) + &
          matmul(fixed%free_opening, answer%theta))
      else
        call part%certify(spoiled, .false., room, answer)
        bound = answer%bound
      end if
      call compare(fixed, exact, spoiled, bound, records(k))
    end do
  end subroutine check_spoiled

  !> Forces that are not negative and wrong in the way of a kind.
  function spoil(exact, kind) result(spoiled)
    real(rk), intent(in) :: exact(:)
    integer, intent(in) :: kind
    real(rk) :: spoiled(size(exact)), share
    integer :: k

    spoiled = exact
    select case (kind)
    case (2)
      do k = 1, size(exact)
        call random%fraction(share)
        spoiled(k) = exact(k) * (1 + 0.01_rk * (2 * share - 1))
      end do
    case (3)
      call random%fraction(share)
      k = 1 + int(share * size(exact))
      ! a closed contact opens, an open one gets the mean force
      spoiled(k) = merge(0.0_rk, sum(exact) / count(exact > 0), exact(k) > 0)
    case default
      spoiled = eoshift(exact, 3)
    end select
  end function spoil

  subroutine compare(fixed, exact, forces, bound, record)
    type(fixed_compliance_t), intent(in) :: fixed
    real(rk), intent(in) :: exact(:)
    real(rk), intent(in) :: forces(:)
    real(rk), intent(in) :: bound
    type(record_t), intent(inout) :: record
    real(rk) :: error, whole

    error = norm_of(fixed, forces - exact)
    whole = max(norm_of(fixed, exact), 1.0e-3_rk * fixed%largest_size)
    record%n_points = record%n_points + 1
    if (.not. bound >= error - rounding * whole) record%n_violations = record%n_violations + 1
    if (error > smallest_error * whole) record%effectivities = [record%effectivities, bound / error]
  end subroutine compare

  real(rk) function norm_of(fixed, forces)
    type(fixed_compliance_t), intent(in) :: fixed
    real(rk), intent(in) :: forces(:)
    real(rk) :: elastic(size(forces))

    elastic = forces
    elastic(fixed%anchors) = 0
    norm_of = sqrt(max(0.0_rk, dot_product(elastic, matmul(fixed%compliance, elastic))))
  end function norm_of

  subroutine print_table()
    type(statistics_t) :: found
    integer :: k

    do k = 1, n_kinds
      if (records(k)%n_points == 0) cycle
      write (*, '(a, i7, " points", i6, " violations")', advance='no') kinds(k), records(k)%n_points, records(k)%n_violations
      if (size(records(k)%effectivities) == 0) then
        write (*, '(a)') ', no error above rounding'
      else
        found = summarize(records(k)%effectivities)
        write (*, '(i7, " errors, effectivity", 3f9.3)') size(records(k)%effectivities), found%median, found%p95, found%maximum
      end if
    end do
    write (*, '(i0, " without an answer, ", i0, " without a reference")') n_unanswered, n_unsolved
    if (any(records%n_violations > 0)) stop 1
  end subroutine print_table
end program check_certificate
