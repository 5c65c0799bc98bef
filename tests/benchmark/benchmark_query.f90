! SPDX-License-Identifier: BSD-3-Clause
!> Single queries of a condensed model at random points of its box, with their certificate, beside a dense solver on the same W and
!> q: the primal-dual active set method, which starts at the closed rows of the nearest training point and factors W of the closed
!> rows by LAPACK in every pass. Both look for that point, evaluate the terms and add them up to q.
!>
!> Arguments: model.h5, number of points, of them those that the dense solver solves, too (the first ones), file. The file gets q
!> and the unknowns z at the latter points, one point after the other, for other solvers.
program benchmark_query
  use, intrinsic :: iso_fortran_env, only: int64
  use sig_answer, only: answer_t
  use sig_compliance, only: compliance_point_t, compliance_t
  use sig_condensed_model, only: condensed_model_t
  use sig_dense_kernels, only: add_few_columns
  use sig_errors, only: error_report, error_t
  use sig_kinds, only: rk
  use sig_model_file, only: read_model
  use sig_online_model, only: online_model_t
  use sig_query, only: query_t
  use sig_term_values, only: term_values_t
  implicit none(type, external)

  !> Times and forces of one way to answer.
  type :: course_t
    !> [s] shape (n_points)
    real(rk), allocatable :: seconds(:)
    !> passes of an active set, or steps of the method
    integer, allocatable :: n_passes(:)
    !> [force] z, shape (n_rows, n_points)
    real(rk), allocatable :: unknowns(:, :)
    !> shape (n_points)
    logical, allocatable :: is_solved(:)
  end type course_t

  interface
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: rk
      implicit none(type, external)
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(rk), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf

    subroutine dpotrs(uplo, n, nrhs, a, lda, b, ldb, info)
      import :: rk
      implicit none(type, external)
      character, intent(in) :: uplo
      integer, intent(in) :: n, nrhs, lda, ldb
      real(rk), intent(in) :: a(lda, *)
      real(rk), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dpotrs

    subroutine dgesv(n, nrhs, a, lda, pivots, b, ldb, info)
      import :: rk
      implicit none(type, external)
      integer, intent(in) :: n, nrhs, lda, ldb
      real(rk), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: pivots(*), info
    end subroutine dgesv
  end interface

  !> each point is asked so often, and the shortest time counts, because a busy machine interrupts some of them
  integer, parameter :: n_repeats = 3
  integer, parameter :: most_passes = 50
  !> [-] of the largest |q|: a smaller overlap is rounding
  real(rk), parameter :: overlap_tolerance = 1.0e-13_rk
  character(1024) :: arguments(4)
  character(:), allocatable :: message
  type(online_model_t) :: online
  type(error_t), allocatable :: error
  type(course_t) :: query, dense
  real(rk), allocatable :: openings(:, :), points(:, :)
  integer :: i, n_dense, n_points

  do i = 1, size(arguments)
    call get_command_argument(i, arguments(i))
  end do
  read (arguments(2), *) n_points
  read (arguments(3), *) n_dense
  call read_model(trim(arguments(1)), online%model, error)
  if (allocated(error)) error stop error_report(error)
  call online%prepare(message)
  if (allocated(message)) error stop message
  call draw_points(online%model%box, n_points, points)
  select type (part => online%model%parts(1)%reduced)
  type is (condensed_model_t)
    if (part%compliance%n_systems() > 1 .or. .not. (part%laws%is_plain() .and. part%compliance%is_fixed())) &
      error stop 'W depends on the point, or there is friction'
    call ask(online, points, query)
    call solve(online, part%compliance, points(:, :n_dense), dense, openings)
    call tell(part%n_rows())
  class default
    error stop 'the model is not condensed'
  end select
  call write_file(trim(arguments(4)))

contains

  !> Draws points of the box, the same for each number of points.
  subroutine draw_points(box, n, points)
    real(rk), intent(in) :: box(:, :)
    integer, intent(in) :: n
    real(rk), allocatable, intent(out) :: points(:, :)
    integer(int64), parameter :: modulus = 2147483647_int64, factor = 48271_int64
    integer(int64) :: state
    integer :: i, k

    allocate (points(size(box, 2), n))
    state = 20220430_int64
    do i = 1, n
      do k = 1, size(box, 2)
        state = modulo(factor * state, modulus)
        points(k, i) = box(1, k) + (box(2, k) - box(1, k)) * real(state, rk) / real(modulus, rk)
      end do
    end do
  end subroutine draw_points

  subroutine create_course(n_rows, n, course)
    integer, intent(in) :: n_rows
    integer, intent(in) :: n
    type(course_t), intent(out) :: course

    allocate (course%seconds(n), source=huge(1.0_rk))
    allocate (course%n_passes(n), course%unknowns(n_rows, n), course%is_solved(n))
  end subroutine create_course

  real(rk) function seconds_now() result(seconds)
    integer(int64) :: count, rate

    call system_clock(count, rate)
    seconds = real(count, rk) / real(rate, rk)
  end function seconds_now

  !> Asks the model.
  subroutine ask(online, points, course)
    type(online_model_t), intent(in) :: online
    real(rk), intent(in) :: points(:, :)
    type(course_t), intent(out) :: course
    type(query_t) :: query
    type(answer_t) :: answer
    character(:), allocatable :: message
    real(rk) :: start
    integer :: i, i_repeat

    call query%create(online, message)
    if (allocated(message)) error stop message
    call create_course(online%model%n_multipliers, size(points, 2), course)
    call query%evaluate(online, points(:, 1), answer)
    do i = 1, size(points, 2)
      do i_repeat = 1, n_repeats
        start = seconds_now()
        call query%evaluate(online, points(:, i), answer)
        course%seconds(i) = min(course%seconds(i), seconds_now() - start)
      end do
      course%is_solved(i) = answer%reason > 0
      course%n_passes(i) = answer%n_iterations
      course%unknowns(:, i) = answer%unknowns
    end do
    call query%destroy()
  end subroutine ask

  !> Solves by the dense active set.
  subroutine solve(online, compliance, points, course, openings)
    type(online_model_t), intent(in) :: online
    class(compliance_t), target, intent(in) :: compliance
    real(rk), intent(in) :: points(:, :)
    type(course_t), intent(out) :: course
    !> [length] q, shape (n_rows, n_points)
    real(rk), allocatable, intent(out) :: openings(:, :)
    type(compliance_point_t), target :: point
    type(term_values_t) :: terms
    character(:), allocatable :: message
    real(rk), pointer, contiguous :: matrix(:, :)
    real(rk), allocatable :: block(:, :), theta(:)
    logical, allocatable :: is_closed(:)
    real(rk) :: distance, start
    integer :: i, i_repeat, i_source, nearest
    logical :: is_valid

    call terms%create(online%model%terms, message)
    if (allocated(message)) error stop message
    call compliance%create_point(point)
    matrix => compliance%matrix(point)
    allocate (theta(online%model%terms%n_terms()), is_closed(size(matrix, 1)))
    allocate (block(size(matrix, 1), size(matrix, 1)), openings(size(matrix, 1), size(points, 2)))
    call create_course(size(matrix, 1), size(points, 2), course)
    do i = 1, size(points, 2)
      do i_repeat = 1, n_repeats
        start = seconds_now()
        call online%nearest_point(points(:, i), nearest, distance)
        call terms%evaluate(points(:, i), theta, is_valid, i_source)
        call compliance%evaluate(theta, point, is_valid)
        call compliance%start_from(nearest, point, is_closed)
        call change_sets(matrix, point%opening, size(compliance%anchors) == 0, is_closed, block, course%unknowns(:, i), &
          course%n_passes(i), course%is_solved(i))
        course%seconds(i) = min(course%seconds(i), seconds_now() - start)
      end do
      openings(:, i) = point%opening
    end do
    call terms%destroy()
  end subroutine solve

  !> The primal-dual active set method for 0 <= z, W z + q >= 0, complementary.
  subroutine change_sets(matrix, q, is_symmetric, is_closed, block, unknowns, n_passes, is_solved)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), contiguous, intent(in) :: q(:)
    logical, intent(in) :: is_symmetric
    !> on entry the start
    logical, intent(inout) :: is_closed(:)
    !> work array of the shape of the matrix
    real(rk), contiguous, intent(inout) :: block(:, :)
    real(rk), contiguous, intent(out) :: unknowns(:)
    integer, intent(out) :: n_passes
    logical, intent(out) :: is_solved
    real(rk) :: w(size(q)), inside(size(q)), smallest
    integer :: closed(size(q)), pivots(size(q))
    integer :: i, info, j, n
    logical :: is_next

    smallest = overlap_tolerance * maxval(abs(q))
    is_solved = .false.
    do n_passes = 1, most_passes
      n = 0
      do i = 1, size(q)
        if (.not. is_closed(i)) cycle
        n = n + 1
        closed(n) = i
      end do
      do j = 1, n
        do i = merge(j, 1, is_symmetric), n
          block(i, j) = matrix(closed(i), closed(j))
        end do
        inside(j) = -q(closed(j))
      end do
      if (is_symmetric) then
        call dpotrf('L', n, block, size(block, 1), info)
        if (info == 0) call dpotrs('L', n, 1, block, size(block, 1), inside, size(inside), info)
      else
        call dgesv(n, 1, block, size(block, 1), pivots, inside, size(inside), info)
      end if
      if (info /= 0) return
      unknowns = 0
      unknowns(closed(:n)) = inside(:n)
      w = q
      call add_few_columns(matrix, unknowns, w)
      is_solved = .true.
      do i = 1, size(q)
        if (is_closed(i)) then
          is_next = unknowns(i) > 0
        else
          is_next = w(i) < -smallest
        end if
        is_solved = is_solved .and. (is_next .eqv. is_closed(i))
        is_closed(i) = is_next
      end do
      if (is_solved) return
    end do
  end subroutine change_sets

  subroutine tell(n_rows)
    integer, intent(in) :: n_rows
    real(rk) :: ratios(n_dense)

    print '(a, 5(1x, i0))', 'rows, points, of them dense; no answer, dense:', n_rows, n_points, n_dense, &
      count(.not. query%is_solved), count(.not. dense%is_solved)
    print '(a, 3(1x, i0))', 'closed: least, median, most', least_median_most(real(count(dense%unknowns > 0, dim=1), rk))
    call tell_course('query', query)
    call tell_course('dense', dense)
    ratios = dense%seconds / query%seconds(:n_dense)
    print '(a, 2(1x, f0.2))', 'dense over query: median, worst point', quantile(ratios, 0.5_rk), minval(ratios)
    print '(a, es9.1)', 'largest difference over the largest unknown:', &
      maxval(abs(query%unknowns(:, :n_dense) - dense%unknowns), mask=spread(dense%is_solved, 1, n_rows)) / maxval(dense%unknowns)
  end subroutine tell

  subroutine tell_course(name, course)
    character(*), intent(in) :: name
    type(course_t), intent(in) :: course

    print '(a, 3(1x, f0.1), a, 2(1x, i0))', name // ', us: median, p99, worst', 1.0e6_rk * quantile(course%seconds, 0.5_rk), &
      1.0e6_rk * quantile(course%seconds, 0.99_rk), 1.0e6_rk * maxval(course%seconds), '; passes: median, most', &
      nint(quantile(real(course%n_passes, rk), 0.5_rk)), maxval(course%n_passes)
  end subroutine tell_course

  function least_median_most(numbers) result(three)
    real(rk), intent(in) :: numbers(:)
    integer :: three(3)

    three = nint([minval(numbers), quantile(numbers, 0.5_rk), maxval(numbers)])
  end function least_median_most

  !> Returns the least number that a share of all numbers do not exceed.
  real(rk) function quantile(numbers, share)
    real(rk), intent(in) :: numbers(:)
    real(rk), intent(in) :: share
    real(rk) :: high, low, middle
    integer :: i

    ! bisection: there are few numbers, and no sort at hand
    low = minval(numbers)
    high = maxval(numbers)
    do i = 1, 60
      middle = (low + high) / 2
      if (count(numbers <= middle) >= share * size(numbers)) then
        high = middle
      else
        low = middle
      end if
    end do
    quantile = high
  end function quantile

  subroutine write_file(path)
    character(*), intent(in) :: path
    integer :: unit

    open (newunit=unit, file=path, access='stream', form='unformatted', status='replace', action='write')
    write (unit) openings, query%unknowns(:, :n_dense)
    close (unit)
  end subroutine write_file
end program benchmark_query
