! SPDX-License-Identifier: BSD-3-Clause
!> Checks of values that are expressions: they must be finite over the box of the parameters, some also within bounds.
module sig_deck_check_values
  use sig_deck_box, only: corners_of, max_corner_parameters, names_of, point_text
  use sig_deck_config, only: deck_config_t, parameter_config_t, value_config_t
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_expression, only: expression_t
  use sig_history, only: states_of
  use sig_kinds, only: rk
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: check_field, check_order, check_range

  !> Which values are allowed: those between two bounds.
  type :: range_t
    real(rk) :: above = 0
    real(rk) :: below = 0
    !> of the value, with a blank before it; may be empty
    character(:), allocatable :: unit
    !> `above` is allowed, too
    logical :: has_bound = .false.
  contains
    procedure :: has
    procedure :: rule_for
  end type range_t

contains

  !> Checks that an expression is finite at the middle and at the corners of the box of the parameters, as check_finite describes.
  !> An expression with coordinates is not checked here, but later on the mesh. Nothing is checked if a parameter has no valid
  !> range.
  subroutine check_field(tree, path, config, value)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the value
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(value_config_t), intent(in) :: value

    if (has_box(config%parameters) .and. .not. value%uses_coordinates) call check_finite(tree, path, config, value)
  end subroutine check_field

  !> Whether min and max of all parameters could be read and each min is less than its max.
  pure logical function has_box(parameters)
    type(parameter_config_t), intent(in) :: parameters(:)

    has_box = all(parameters%minimum < parameters%maximum .and. parameters%minimum > -huge(1.0_rk) .and. &
      parameters%maximum < huge(1.0_rk))
  end function has_box

  !> Checks that a number lies between two bounds. An expression must be finite and lie between them at the middle and at the
  !> corners of the box of the parameters, as check_finite describes; it is not checked if a parameter has no valid range.
  subroutine check_range(tree, path, config, value, above, below, unit, may_be_bound)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the value
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(value_config_t), intent(in) :: value
    !> the value must be greater than this
    real(rk), intent(in) :: above
    !> the value must be less than this; huge: no bound
    real(rk), intent(in) :: below
    !> unit of the value for messages, with a blank before it; may be empty
    character(*), intent(in) :: unit
    !> the value may also be equal to `above`; default: it may not
    logical, intent(in), optional :: may_be_bound
    type(range_t) :: range

    range = range_t(above, below, unit)
    if (present(may_be_bound)) range%has_bound = may_be_bound
    if (value%is_constant) then
      if (.not. range%has(value%constant)) &
        call tree%report_at(path, 'is ' // to_text(value%constant) // unit // range%rule_for(value%constant))
    else if (has_box(config%parameters)) then
      call check_finite(tree, path, config, value, range)
    end if
  end subroutine check_range

  pure logical function has(self, value)
    class(range_t), intent(in) :: self
    real(rk), intent(in) :: value

    has = value < self%below .and. (value > self%above .or. (self%has_bound .and. value >= self%above))
  end function has

  !> Returns the end of the message for a value that is not in the range: the bound that it breaks. Requires: `above` is a whole
  !> number.
  pure function rule_for(self, value) result(text)
    class(range_t), intent(in) :: self
    real(rk), intent(in) :: value
    character(:), allocatable :: text

    text = '; it must be less than ' // to_text(self%below)
    if (value >= self%below) return
    text = '; it must be greater than ' // to_text(nint(self%above))
    if (self%has_bound) text = '; it must be at least ' // to_text(nint(self%above))
  end function rule_for

  !> Checks that one value is less than another one, or at least as large, at the middle and at the corners of the box, as
  !> check_finite describes. Not checked: values that are not finite there, and those with a name that is no parameter.
  subroutine check_order(tree, path, config, value, other, must_be_less, rule, unit)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the value
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(value_config_t), intent(in) :: value, other
    !> whether value < other is wanted; otherwise value >= other
    logical, intent(in) :: must_be_less
    !> what the value must be, with the name of the other one at the end, such as `less than young_modulus`
    character(*), intent(in) :: rule
    !> unit of both values for messages, with a blank before it; may be empty
    character(*), intent(in) :: unit
    type(value_config_t) :: both
    type(expression_t) :: expressions(3)
    character(:), allocatable :: found, message, place
    real(rk), allocatable :: states(:, :)
    real(rk) :: values(2)
    integer :: i, k
    logical :: are_valid(2)

    if (.not. has_box(config%parameters)) return
    both%text = '(' // value%text // ')+(' // other%text // ')'
    both%uses_history = value%uses_history .or. other%uses_history
    work: block
      call expressions(1)%create(value%text, names_of(config%state_parameters), message, is_composed=.true.)
      if (allocated(message)) exit work
      call expressions(2)%create(other%text, names_of(config%state_parameters), message, is_composed=.true.)
      if (allocated(message)) exit work
      call expressions(3)%create(both%text, names_of(config%state_parameters), message, is_composed=.true.)
      if (allocated(message)) exit work
      call find_states(config, both, expressions(3)%used_places(), states)
      do i = 1, size(states, 2)
        do k = 1, 2
          call expressions(k)%evaluate(states(:, i), values(k), are_valid(k))
        end do
        if (.not. all(are_valid) .or. (must_be_less .eqv. values(1) < values(2))) cycle
        found = 'is ' // to_text(values(1)) // unit
        place = ''
        if (.not. value%is_constant) found = 'is ' // shown(value%text) // ', which ' // found
        if (.not. (value%is_constant .and. other%is_constant)) place = ' at ' // point_text(config%state_parameters, states(:, i))
        call tree%report_at(path, found // place // '; it must be ' // rule // ', which is ' // to_text(values(2)) // unit)
        exit
      end do
    end block work
    do k = 1, size(expressions)
      call expressions(k)%destroy()
    end do
  end subroutine check_order

  !> Checks that an expression is finite, and within its bounds if there are any, at the middle and at the corners of the box, where
  !> divisions by zero are likely. Corners differ in the first 10 parameters of the expression; all other parameters are at their
  !> minimum there. Adds an error for the first of these points where it is not. Not checked: a constant, and an expression with a
  !> name that is no parameter or cannot be used.
  subroutine check_finite(tree, path, config, value, range)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(value_config_t), intent(in) :: value
    !> default: any finite value is allowed
    type(range_t), intent(in), optional :: range
    type(expression_t) :: expression
    character(:), allocatable :: message
    real(rk), allocatable :: states(:, :)
    real(rk) :: result
    integer :: i
    logical :: is_valid

    if (value%is_constant) return
    associate (all => config%state_parameters)
      call expression%create(value%text, names_of(all), message, is_composed=.true.)
      ! a parameter with an invalid name, which was reported already
      if (allocated(message)) return
      call find_states(config, value, expression%used_places(), states)
      do i = 1, size(states, 2)
        call expression%evaluate(states(:, i), result, is_valid)
        if (.not. is_valid) then
          call tree%report_at(path, 'is ' // shown(value%text) // ', which is not finite at ' // point_text(all, states(:, i)))
          exit
        else if (present(range)) then
          if (range%has(result)) cycle
          call tree%report_at(path, 'is ' // shown(value%text) // ', which is ' // to_text(result) // range%unit // &
            ' at ' // point_text(all, states(:, i)) // range%rule_for(result))
          exit
        end if
      end do
    end associate
    call expression%destroy()
  end subroutine check_finite

  !> Finds the states at which an expression is tried: the middle and the corners of the box that check_finite describes, with a
  !> history at all of its times; none where a table is not valid, which was reported already.
  subroutine find_states(config, value, used_places, states)
    type(deck_config_t), intent(in) :: config
    type(value_config_t), intent(in) :: value
    !> places of the names that the expression has among state_parameters
    integer, intent(in) :: used_places(:)
    !> shape (size(state_parameters), n_states)
    real(rk), allocatable, intent(out) :: states(:, :)
    integer, allocatable :: varied(:)
    character(:), allocatable :: fault
    integer :: i, i_bad_point

    varied = pack(used_places, used_places <= size(config%parameters))
    ! tables may depend on every parameter
    if (value%uses_history) varied = [(i, i=1, size(config%parameters))]
    varied = varied(:min(size(varied), max_corner_parameters))
    call states_of(config%history%states, names_of(config%parameters), corners_of(config%parameters, varied), states, &
      i_bad_point, fault)
    if (allocated(fault)) states = states(:, :0)
  end subroutine find_states
end module sig_deck_check_values
