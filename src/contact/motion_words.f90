! SPDX-License-Identifier: BSD-3-Clause
!> Rigid motions in words, for messages: `translation in x, rotation about z`.
module sig_motion_words
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  use sig_rigid_bodies, only: null_space, rigid_bodies_t
  use sig_rigid_motions, only: rigid_motions_t
  use sig_rounding, only: dependent
  use sig_singular_values, only: svd
  use sig_text, only: append_text, join, string_t, to_text
  implicit none(type, external)
  private
  public :: amplitudes_of_body, bodies_of_motions, held_amplitudes, motion_text, unheld_motions

  !> [-] a direction this close to an axis is called after it
  real(rk), parameter :: aligned = 1.0e-3_rk

contains

  !> Returns the combinations of the free motions that change the gap of no contact row, or of none of some rows, so that these do
  !> not hold them: one per column, orthonormal, shape (n_free, n). n is 0 if every combination changes some gap, or if there are no
  !> free motions.
  function unheld_motions(motions, is_holding) result(combinations)
    type(rigid_motions_t), intent(in) :: motions
    !> the rows that count, shape (n_rows); default: all
    logical, intent(in), optional :: is_holding(:)
    real(rk), allocatable :: combinations(:, :)
    real(rk) :: closing(size(motions%closing, 1), motions%n_free)

    closing = motions%closing
    if (present(is_holding)) closing = merge(closing, 0.0_rk, spread(is_holding, 2, motions%n_free))
    combinations = null_space(matmul(transpose(closing), closing))
  end function unheld_motions

  !> Returns the bodies that take part in at least one of some combinations of the free motions, 1-based, ascending.
  pure function bodies_of_motions(motions, combinations) result(bodies)
    type(rigid_motions_t), intent(in) :: motions
    !> shape (n_free, n); amplitudes up to 1e-6 in size count as none
    real(rk), intent(in) :: combinations(:, :)
    integer, allocatable :: bodies(:)
    integer :: i, i_body

    allocate (bodies(0))
    do i_body = 1, motions%n_bodies
      if (any([(motions%body_of_motion(i) == i_body .and. any(abs(combinations(i, :)) > dependent), i=1, motions%n_free)])) &
        bodies = [bodies, i_body]
    end do
  end function bodies_of_motions

  !> Returns the amplitudes of the rigid modes of one body in combinations of the free motions, shape (n_rigid, n).
  pure function amplitudes_of_body(motions, combinations, i_body) result(amplitudes)
    type(rigid_motions_t), intent(in) :: motions
    !> shape (n_free, n)
    real(rk), intent(in) :: combinations(:, :)
    !> 1-based
    integer, intent(in) :: i_body
    real(rk) :: amplitudes(motions%n_rigid, size(combinations, 2))
    integer :: i

    associate (own => pack([(i, i=1, motions%n_free)], motions%body_of_motion == i_body))
      amplitudes = matmul(motions%amplitudes(:, own), combinations(own, :))
    end associate
  end function amplitudes_of_body

  !> Returns the amplitudes of the free motions of one body, each with those idle motions that it carries that leave it the least
  !> rotation, then the least translation; shape (n_rigid, n).
  function held_amplitudes(motions, i_body) result(amplitudes)
    type(rigid_motions_t), intent(in) :: motions
    !> 1-based
    integer, intent(in) :: i_body
    real(rk), allocatable :: amplitudes(:, :)
    !> [-] weight of rotations beside translations in the sum of squares
    real(rk), parameter :: weight_of_rotation = 1.0e4_rk
    real(rk), allocatable :: idle(:, :), shares(:, :), weighted(:, :)
    integer :: i
    logical :: is_singular

    associate (own => pack([(i, i=1, motions%n_free)], motions%body_of_motion == i_body), &
      carried => pack([(i, i=1, motions%idle%n)], motions%idle%carriers == i_body))
      amplitudes = motions%amplitudes(:, own)
      idle = motions%idle%amplitudes(:, i_body, carried)
    end associate
    if (size(idle, 2) == 0) return
    weighted = idle
    weighted(size(motions%coordinates, 1) + 1:, :) = weight_of_rotation * weighted(size(motions%coordinates, 1) + 1:, :)
    allocate (shares(size(idle, 2), size(amplitudes, 2)))
    call solve_dense(matmul(transpose(weighted), idle), matmul(transpose(weighted), amplitudes), shares, is_singular)
    if (.not. is_singular) amplitudes = amplitudes - matmul(idle, shares)
  end function held_amplitudes

  !> Returns some motions of one body as a text, such as `translation in x, rotation about z`. A rotation in the plane is just
  !> `rotation`. What is not along or about a coordinate axis is `translation along (0.6, 0.8)`, `translation in a plane` or
  !> `rotation about an oblique axis`. In axisymmetry the text is always the axial translation.
  function motion_text(bodies, amplitudes, axes) result(text)
    class(rigid_bodies_t), intent(in) :: bodies
    !> of the rigid modes of the body, at least one is not zero; shape (n_rigid, n)
    real(rk), intent(in) :: amplitudes(:, :)
    !> names of the coordinates, at least n_dim
    character(1), intent(in) :: axes(:)
    character(:), allocatable :: text
    type(string_t), allocatable :: words(:)
    real(rk), allocatable :: modes(:, :), u(:, :), s(:), vt(:, :)
    integer :: n_dim

    if (bodies%is_round) then
      text = 'translation in ' // axes(2)
      return
    end if
    n_dim = size(bodies%coordinates, 1)
    call svd(amplitudes, u, s, vt)
    modes = u(:, :count(s > aligned * s(1)))
    ! a rotation that is rounding must not hide the translation
    modes = merge(0.0_rk, modes, abs(modes) < aligned)
    allocate (words(0))
    associate (rotations => modes(n_dim + 1:, :))
      call add_translations(matmul(modes(:n_dim, :), null_space(matmul(transpose(rotations), rotations))), axes, words)
      call add_rotations(rotations, axes, words)
    end associate
    text = join(words, ', ')
  end function motion_text

  subroutine add_translations(directions, axes, words)
    !> orthonormal, shape (n_dim, n)
    real(rk), intent(in) :: directions(:, :)
    character(1), intent(in) :: axes(:)
    type(string_t), allocatable, intent(inout) :: words(:)
    type(string_t) :: numbers(size(directions, 1))
    integer :: i, n_named

    n_named = 0
    do i = 1, size(directions, 1)
      if (norm2(directions(i, :)) < 1 - aligned) cycle
      call append_text(words, 'translation in ' // axes(i))
      n_named = n_named + 1
    end do
    if (size(directions, 2) == n_named) return
    if (size(directions, 2) > n_named + 1) then
      call append_text(words, 'translation in a plane')
      return
    end if
    do i = 1, size(numbers)
      numbers(i)%text = to_text(nint(1000 * directions(i, size(directions, 2))) / 1000.0_rk)
    end do
    call append_text(words, 'translation along (' // join(numbers, ', ') // ')')
  end subroutine add_translations

  subroutine add_rotations(rotations, axes, words)
    !> angles, shape (1 or 3, n)
    real(rk), intent(in) :: rotations(:, :)
    character(1), intent(in) :: axes(:)
    type(string_t), allocatable, intent(inout) :: words(:)
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: i, n, n_named

    call svd(rotations, u, s, vt)
    n = count(s > aligned)
    n_named = 0
    do i = 1, size(rotations, 1)
      if (norm2(u(i, :n)) < 1 - aligned) cycle
      if (size(rotations, 1) == 1) call append_text(words, 'rotation')
      if (size(rotations, 1) == 3) call append_text(words, 'rotation about ' // axes(i))
      n_named = n_named + 1
    end do
    if (n > n_named) call append_text(words, 'rotation about an oblique axis')
  end subroutine add_rotations
end module sig_motion_words
