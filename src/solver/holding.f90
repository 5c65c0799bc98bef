! SPDX-License-Identifier: BSD-3-Clause
!> The closed pairs that hold the bodies which nothing else holds. The active set must never open the last of them; the condensed
!> problem takes some of them as anchors.
module sig_holding
  use sig_kinds, only: rk
  use sig_linear_algebra, only: invert, solve_dense
  use sig_rigid_motions, only: rigid_motions_t
  use sig_rounding, only: dependent, rounding
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: keep_hold, is_last_hold, letting_go, first_to_block, change_first
  public :: anchors_t, find_anchors

  !> Anchors T: as many pairs as there are free motions. They alone would hold the bodies.
  type :: anchors_t
    !> shape (n_free)
    integer, allocatable :: rows(:)
    !> column j: amplitudes of the free motion that closes anchor j by 1 and moves no other anchor, B_T Z amplitudes = 1; shape
    !> (n_free, n_free)
    real(rk), allocatable :: amplitudes(:, :)
    !> [-] closing of all pairs by these motions, shape (n_rows, n_free)
    real(rk), allocatable :: closing(:, :)
  end type anchors_t

contains

  !> Adds closed pairs to the wanted set until it holds the bodies, each time a pair that stops a motion which the set does not stop
  !> yet. Of these the pair with the largest multiplier comes first (above 0 presses, below 0 pulls).
  pure subroutine keep_hold(motions, is_closed, multipliers, wanted)
    type(rigid_motions_t), intent(in) :: motions
    !> a set that holds the bodies, shape (n_rows)
    logical, intent(in) :: is_closed(:)
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> in: the wanted set; out: with the added pairs; shape (n_rows)
    logical, intent(inout) :: wanted(:)
    real(rk) :: held(motions%n_free, motions%n_free)
    integer :: n_held, next

    if (motions%n_free == 0) return
    call span_of(motions, wanted, held, n_held)
    do while (n_held < motions%n_free)
      next = least_pulling(motions, is_closed .and. .not. wanted, multipliers, held(:, :n_held))
      if (next == 0) return
      wanted(next) = .true.
      n_held = n_held + 1
      held(:, n_held) = remainder_of(motions%closing(next, :), held(:, :n_held - 1))
      held(:, n_held) = held(:, n_held) / norm2(held(:, n_held))
    end do
  end subroutine keep_hold

  !> Computes an orthonormal basis of the motions that a set of pairs holds, in amplitudes of the free motions.
  pure subroutine span_of(motions, is_closed, held, n_held)
    type(rigid_motions_t), intent(in) :: motions
    !> the set, shape (n_rows)
    logical, intent(in) :: is_closed(:)
    !> [-] the basis is the first n_held columns; shape (n_free, n_free)
    real(rk), intent(out) :: held(:, :)
    !> number of independent motions that the set holds
    integer, intent(out) :: n_held
    integer :: i
    integer, allocatable :: rows(:)

    rows = independent_rows(motions, is_closed)
    n_held = size(rows)
    do i = 1, n_held
      held(:, i) = remainder_of(motions%closing(rows(i), :), held(:, :i - 1))
      held(:, i) = held(:, i) / norm2(held(:, i))
    end do
  end subroutine span_of

  !> Returns the numbers of pairs of a set that together hold all motions that the set holds, 1-based, in the order of choice: each
  !> time the pair that adds most, of nearly equal ones the first. A pair that adds only rounding is left out.
  pure function independent_rows(motions, is_closed) result(rows)
    type(rigid_motions_t), intent(in) :: motions
    !> the set, shape (n_rows)
    logical, intent(in) :: is_closed(:)
    integer, allocatable :: rows(:)
    real(rk) :: rest(size(is_closed), motions%n_free), sizes(size(is_closed)), direction(motions%n_free)
    integer :: i

    allocate (rows(0))
    rest = motions%closing
    do i = 1, motions%n_free
      sizes = merge(norm2(rest, dim=2), 0.0_rk, is_closed)
      if (size(sizes) == 0) return
      if (maxval(sizes) <= dependent) return
      rows = [rows, first_largest(sizes)]
      direction = rest(rows(i), :) / norm2(rest(rows(i), :))
      rest = rest - spread(matmul(rest, direction), 2, motions%n_free) * spread(direction, 1, size(is_closed))
    end do
  end function independent_rows

  !> Returns what is left of a row when its components along the held motions are taken away.
  pure function remainder_of(row, held) result(rest)
    !> row of B Z, shape (n_free)
    real(rk), intent(in) :: row(:)
    !> [-] orthonormal basis of the held motions, in amplitudes of the free motions; shape (n_free, n_held)
    real(rk), intent(in) :: held(:, :)
    real(rk) :: rest(size(row))

    rest = row - matmul(held, matmul(row, held))
    rest = rest - matmul(held, matmul(rest, held))
  end function remainder_of

  !> Returns the candidate with the largest multiplier among those that hold a further motion, 1-based; 0 if there is none.
  pure integer function least_pulling(motions, is_candidate, multipliers, held) result(best)
    type(rigid_motions_t), intent(in) :: motions
    !> shape (n_rows)
    logical, intent(in) :: is_candidate(:)
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> [-] orthonormal basis of the held motions, in amplitudes of the free motions; shape (n_free, n_held)
    real(rk), intent(in) :: held(:, :)
    integer :: k

    best = 0
    do k = 1, size(is_candidate)
      if (.not. is_candidate(k)) cycle
      if (best > 0) then
        if (multipliers(k) <= multipliers(best)) cycle
      end if
      if (norm2(remainder_of(motions%closing(k, :), held)) > dependent) best = k
    end do
  end function least_pulling

  !> Chooses anchors from all pairs; none if there are no free motions. Requires: the pairs can hold the bodies.
  subroutine find_anchors(motions, anchors)
    type(rigid_motions_t), intent(in) :: motions
    type(anchors_t), intent(out) :: anchors
    logical :: is_singular

    anchors%rows = independent_rows(motions, spread(.true., 1, size(motions%closing, 1)))
    allocate (anchors%amplitudes(motions%n_free, motions%n_free))
    call invert(motions%closing(anchors%rows, :), anchors%amplitudes, is_singular)
    anchors%closing = matmul(motions%closing, anchors%amplitudes)
    ! A contact across a motion does not hold it, however large its force is.
    if (size(anchors%closing) > 0) then
      where (abs(anchors%closing) <= rounding * maxval(abs(anchors%closing))) anchors%closing = 0
    end if
  end subroutine find_anchors

  !> Returns for each closed pair whether a body is no longer held when this pair opens: its share in holding the motions is then
  !> one. It is false for open pairs, and for all pairs if there are no free motions or the set does not hold the bodies.
  function is_last_hold(motions, is_closed) result(is_last)
    type(rigid_motions_t), intent(in) :: motions
    !> a set that holds the bodies
    logical, intent(in) :: is_closed(:)
    logical :: is_last(size(is_closed))
    real(rk) :: solved(motions%n_free, size(is_closed))
    logical :: is_singular
    integer :: k

    is_last = .false.
    if (motions%n_free == 0) return
    call solve_dense(gram_of(motions, is_closed), transpose(motions%closing), solved, is_singular)
    if (is_singular) return
    do k = 1, size(is_closed)
      if (is_closed(k)) is_last(k) = dot_product(motions%closing(k, :), solved(:, k)) > 1 - dependent
    end do
  end function is_last_hold

  !> Returns the amplitudes of the free motion that opens pair k by 1 and leaves all other closed pairs closed. Requires:
  !> is_last_hold is true for this pair.
  function letting_go(motions, is_closed, k) result(amplitudes)
    type(rigid_motions_t), intent(in) :: motions
    !> a set that holds the bodies, shape (n_rows)
    logical, intent(in) :: is_closed(:)
    !> pair, 1-based
    integer, intent(in) :: k
    real(rk) :: amplitudes(motions%n_free)
    logical :: is_singular

    ! least squares of B Z a = -e_k on the closed rows, which have a solution
    call solve_dense(gram_of(motions, is_closed), -motions%closing(k, :), amplitudes, is_singular)
  end function letting_go

  !> Returns the Gram matrix (B Z)' B Z of the closed rows.
  function gram_of(motions, is_closed) result(gram)
    type(rigid_motions_t), intent(in) :: motions
    logical, intent(in) :: is_closed(:)
    real(rk) :: gram(motions%n_free, motions%n_free)
    integer :: k

    associate (rows => motions%closing(pack([(k, k=1, size(is_closed))], is_closed), :))
      gram = matmul(transpose(rows), rows)
    end associate
  end function gram_of

  !> Returns the open pair that stops a motion first, 1-based. It is 0 if no pair stops the motion: forces along it then have no
  !> equilibrium.
  pure integer function first_to_block(motions, is_closed, amplitudes, opening) result(first)
    type(rigid_motions_t), intent(in) :: motions
    !> closed pairs, which do not stop the motion; shape (n_rows)
    logical, intent(in) :: is_closed(:)
    !> amplitudes of the motion, shape (n_free)
    real(rk), intent(in) :: amplitudes(:)
    !> [length] opening of each pair, shape (n_rows); a negative one counts as 0
    real(rk), intent(in) :: opening(:)
    real(rk) :: closing(size(is_closed)), reach, shortest
    integer :: k

    closing = matmul(motions%closing, amplitudes)
    first = 0
    shortest = huge(shortest)
    do k = 1, size(is_closed)
      if (is_closed(k) .or. closing(k) <= dependent * maxval(abs(closing))) cycle
      reach = max(0.0_rk, opening(k)) / closing(k)
      if (reach >= shortest) cycle
      shortest = reach
      first = k
    end do
  end function first_to_block

  !> Returns the current set with only one of the wanted changes, that of the pair with the lowest number. If this change opens the
  !> last pair that holds a body, the open pair with the lowest number that can hold the body instead closes. Without such a pair
  !> the set stays as it is: there is no equilibrium. It stays, too, if no change is wanted.
  !>
  !> This is the criss-cross method: a pair that is no last hold is a pivot on the diagonal, an exchange one on two rows. By least
  !> index it ends for every problem whose matrix is positive semidefinite, also with bodies that contact holds (den Hertog, Roos
  !> and Terlaky, Linear Algebra and its Applications 187, 1993).
  function change_first(motions, is_closed, wanted) result(next)
    type(rigid_motions_t), intent(in) :: motions
    !> a set that holds the bodies
    logical, intent(in) :: is_closed(:)
    !> set that the last step asks for, shape (n_rows)
    logical, intent(in) :: wanted(:)
    logical :: next(size(is_closed)), is_last(size(is_closed))
    real(rk) :: closing(size(is_closed))
    integer :: first, other

    next = is_closed
    first = findloc(is_closed .neqv. wanted, .true., dim=1)
    if (first == 0) return
    is_last = is_last_hold(motions, is_closed)
    if (is_last(first)) then
      closing = matmul(motions%closing, letting_go(motions, is_closed, first))
      other = findloc(.not. is_closed .and. closing > dependent * maxval(abs(closing)), .true., dim=1)
      if (other == 0) return
      next(other) = .true.
    end if
    next(first) = wanted(first)
  end function change_first
end module sig_holding
