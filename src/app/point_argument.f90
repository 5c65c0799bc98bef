! SPDX-License-Identifier: BSD-3-Clause
!> Parameter points of the command line: `--at a=1,b=2`.
module sig_point_argument
  use sig_deck_box, only: names_of
  use sig_deck_config, only: deck_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_parameter_space, only: find_states
  use sig_text, only: did_you_mean, join, read_real, split, string_t
  implicit none(type, external)
  private
  public :: parse_point, parse_states

contains

  !> Reads the point of --at. Ranges are not checked. Errors: a piece between commas that is no `name=value`, an unknown, repeated
  !> or missing parameter, a value that is no finite decimal number.
  subroutine parse_point(text, names, points, error)
    !> `a=1,b=2`
    character(*), intent(in) :: text
    !> of all parameters
    type(string_t), intent(in) :: names(:)
    !> values in the order of the names, shape (n_parameters, 1)
    real(rk), allocatable, intent(out) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: entries(:)
    logical :: is_set(size(names))
    integer :: i

    allocate (points(size(names), 1), source=0.0_rk)
    is_set = .false.
    entries = split(text, ',')
    do i = 1, size(entries)
      call take_entry(entries(i)%text, names, points(:, 1), is_set, error)
      if (allocated(error)) return
    end do
    if (.not. all(is_set)) call make_error(error, '--at ' // text // ' gives no value for ' // &
      join(pack(names, .not. is_set), ', '), hint='write --at ' // join(names, '=...,') // '=...')
  end subroutine parse_point

  !> Reads the point of --at for a deck and finds its states (find_states). Errors: those of parse_point and find_states.
  subroutine parse_states(text, deck, states, error)
    !> `a=1,b=2`
    character(*), intent(in) :: text
    type(deck_config_t), intent(in) :: deck
    !> shape (size(deck%state_parameters), n_states)
    real(rk), allocatable, intent(out) :: states(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: points(:, :)

    call parse_point(text, names_of(deck%parameters), points, error)
    if (.not. allocated(error)) call find_states(deck, points, states, error)
  end subroutine parse_states

  subroutine take_entry(entry, names, point, is_set, error)
    character(*), intent(in) :: entry
    type(string_t), intent(in) :: names(:)
    real(rk), intent(inout) :: point(:)
    logical, intent(inout) :: is_set(:)
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name, hint
    integer :: i, equals
    logical :: is_valid

    equals = index(entry, '=')
    name = trim(adjustl(entry(:max(equals - 1, 0))))
    do i = 1, size(names)
      if (names(i)%text == name) exit
    end do
    if (equals == 0) then
      call make_error(error, '--at needs name=value, not ''' // entry // '''; the parameters are ' // join(names, ', '))
    else if (i > size(names)) then
      hint = did_you_mean(name, names)
      if (hint /= '') hint = 'did you mean ''' // hint // '''?'
      call make_error(error, 'unknown parameter ''' // name // ''' in --at; the parameters are ' // join(names, ', '), hint=hint)
    else if (is_set(i)) then
      call make_error(error, '--at gives ' // name // ' twice')
    else
      call read_real(trim(adjustl(entry(equals + 1:))), point(i), is_valid)
      is_set(i) = .true.
      if (.not. is_valid) call make_error(error, '--at: ''' // entry(equals + 1:) // ''' is not a number')
    end if
  end subroutine take_entry
end module sig_point_argument
