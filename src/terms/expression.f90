! SPDX-License-Identifier: BSD-3-Clause
!> Expressions of named variables, such as `-squeeze`, `max(a, 0.1) * 2`, `squeeze > 0.2 ? 1 : 0`. muParser evaluates them.
module sig_expression
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_int, c_null_char, c_null_ptr, c_ptr, c_size_t
  use sig_kinds, only: rk
  use sig_text, only: append_text, did_you_mean, join, string_t, to_text
  implicit none(type, external)
  private
  public :: expression_t, function_names, is_function_name, is_identifier, max_composed

  !> the codes of include/signorom/expression.h
  enum, bind(c)
    enumerator :: no_fault = 0, no_memory = 1, bad_name = 2, unknown_name = 3, bad_syntax = 4, several_values = 5
  end enum

  !> [characters] room for the word that muParser complains about and for its message
  integer, parameter :: max_message = 256

  !> [characters] most in one expression of the deck
  integer, parameter :: max_expression = 1000
  !> [characters] most in one expression that the program composes from expressions of the deck. muParser writes its messages, up to
  !> 120 characters and a piece of the expression, into a fixed buffer of 2048 bytes without a check.
  integer, parameter :: max_composed = 1900

  character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'

  !> A compiled expression. Two threads must not use the same one. A copy shares muParser's handle, so destroy only one of them.
  type :: expression_t
    private
    type(c_ptr) :: handle = c_null_ptr
    !> number of values that `evaluate` takes, one per name that `create` got
    integer :: n_values = 0
    !> only the names that may occur in the text, because a deck can have thousands of names
    type(string_t), allocatable :: names(:)
    !> place of the value of each of these names among the values that `evaluate` takes
    integer, allocatable :: places(:)
  contains
    procedure :: create
    procedure :: evaluate
    procedure :: uses
    procedure :: used_places
    procedure :: destroy
  end type expression_t

  interface
    integer(c_int) function sig_expression_create(text, text_length, names, name_width, n_names, places, expression, &
      position, token, message, size) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      implicit none(type, external)
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value, intent(in) :: text_length
      character(kind=c_char), intent(in) :: names(*)
      integer(c_size_t), value, intent(in) :: name_width
      integer(c_int), value, intent(in) :: n_names
      integer(c_int), intent(in) :: places(*)
      type(c_ptr), intent(out) :: expression
      integer(c_int), intent(out) :: position
      character(kind=c_char), intent(out) :: token(*)
      character(kind=c_char), intent(out) :: message(*)
      integer(c_size_t), value, intent(in) :: size
    end function sig_expression_create

    integer(c_int) function sig_expression_evaluate(expression, values, result) bind(c)
      import :: c_double, c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: expression
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(out) :: result
    end function sig_expression_evaluate

    integer(c_int) function sig_expression_uses(expression, i) bind(c)
      import :: c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: expression
      integer(c_int), value, intent(in) :: i
    end function sig_expression_uses

    subroutine sig_expression_free(expression) bind(c)
      import :: c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: expression
    end subroutine sig_expression_free
  end interface

contains

  !> Compiles a text that may contain the variables in `names`.
  !>
  !> Errors: message is allocated when the text is blank, longer than 1000 characters (composed: 1900), not a valid expression with
  !> one value, has a variable whose name is not allowed, or when memory is short. It says what is wrong, and where in the text if
  !> this is known. Then nothing is compiled.
  subroutine create(this, text, names, message, is_composed)
    !> what was compiled before is freed
    class(expression_t), intent(inout) :: this
    character(*), intent(in) :: text
    !> names of the variables
    type(string_t), intent(in) :: names(:)
    !> why the text was refused
    character(:), allocatable, intent(out) :: message
    !> the program has composed the text from expressions of the deck; default: false
    logical, intent(in), optional :: is_composed
    character(max_message) :: token, sentence
    integer(c_int) :: code, position
    integer :: i, longest

    call this%destroy()
    longest = max_expression
    if (present(is_composed)) longest = merge(max_composed, max_expression, is_composed)
    if (len_trim(text) == 0) then
      message = 'the expression is empty'
      return
    else if (len(text) > longest) then
      message = 'the expression is longer than ' // to_text(longest) // ' characters'
      return
    end if
    this%n_values = size(names)
    this%places = pack([(i, i=1, size(names))], [(index(text, names(i)%text) > 0, i=1, size(names))])
    ! gfortran 12 leaks texts behind a vector subscript
    allocate (this%names(size(this%places)))
    do i = 1, size(this%places)
      this%names(i)%text = names(this%places(i))%text
    end do
    call call_c(text, this%names, this%places, this%handle, code, position, token, sentence)
    if (code /= no_fault) then
      call this%destroy()
      message = explain(text, names, code, position, trim(token), trim(sentence))
    end if
  end subroutine create

  !> Computes the result for `values`, one per name that `create` got and in the same order. is_valid is false when the result is
  !> infinite or not a number, when the expression is not compiled, or when the number of values is wrong; do not use `result` then.
  subroutine evaluate(this, values, result, is_valid)
    class(expression_t), intent(in) :: this
    !> shape (number of names)
    real(rk), intent(in) :: values(:)
    real(rk), intent(out) :: result
    logical, intent(out) :: is_valid
    real(c_double) :: number

    result = 0
    is_valid = .false.
    if (.not. c_associated(this%handle)) return
    if (size(values) /= this%n_values) return
    is_valid = sig_expression_evaluate(this%handle, values, number) == 1
    result = number
  end subroutine evaluate

  !> Whether the variable `name` occurs in the text. False before `create`, and for a name that `create` did not get.
  logical function uses(this, name)
    class(expression_t), intent(in) :: this
    character(*), intent(in) :: name
    integer :: i_name

    uses = .false.
    if (.not. c_associated(this%handle)) return
    do i_name = 1, size(this%names)
      if (this%names(i_name)%text /= name) cycle
      uses = sig_expression_uses(this%handle, int(i_name - 1, c_int)) == 1
    end do
  end function uses

  !> Returns the positions, 1-based and ascending, of the variables that occur in the text among the names that `create` got; empty
  !> before `create`.
  function used_places(this) result(places)
    class(expression_t), intent(in) :: this
    integer, allocatable :: places(:)
    integer :: i

    allocate (places(0))
    if (.not. c_associated(this%handle)) return
    places = pack(this%places, [(sig_expression_uses(this%handle, int(i - 1, c_int)) == 1, i=1, size(this%places))])
  end function used_places

  !> Frees the compiled expression. Does nothing when there is none.
  subroutine destroy(this)
    class(expression_t), intent(inout) :: this

    if (c_associated(this%handle)) call sig_expression_free(this%handle)
    this%handle = c_null_ptr
    if (allocated(this%names)) deallocate (this%names, this%places)
  end subroutine destroy

  !> Returns the names of muParser's functions and constants, which a parameter cannot have.
  pure function function_names() result(names)
    type(string_t), allocatable :: names(:)
    character(*), parameter :: known(28) = [character(5) :: 'sin', 'cos', 'tan', 'asin', 'acos', 'atan', 'atan2', 'sinh', &
      'cosh', 'tanh', 'asinh', 'acosh', 'atanh', 'log2', 'log10', 'log', 'ln', 'exp', 'sqrt', 'sign', 'rint', 'abs', &
      'sum', 'avg', 'min', 'max', '_pi', '_e']
    integer :: i_name

    allocate (names(size(known)))
    do i_name = 1, size(known)
      names(i_name)%text = trim(known(i_name))
    end do
  end function function_names

  !> Whether `name` is one of muParser's functions or constants (function_names). Upper and lower case differ.
  pure logical function is_function_name(name)
    character(*), intent(in) :: name
    type(string_t), allocatable :: names(:)
    integer :: i_name

    is_function_name = .false.
    allocate (names, source=function_names())
    do i_name = 1, size(names)
      if (names(i_name)%text == name) is_function_name = .true.
    end do
  end function is_function_name

  !> Whether the name is a letter (a to z, A to Z), then such letters, digits and underscores, as expressions require. False for an
  !> empty name.
  pure logical function is_identifier(name)
    character(*), intent(in) :: name

    is_identifier = len(name) > 0
    if (is_identifier) is_identifier = index(letters, name(1:1)) > 0 .and. verify(name, letters // '0123456789_') == 0
  end function is_identifier

  !> Writes all names into one text, each padded with blanks to the same width, as sig_expression_create takes them.
  pure subroutine pack_names(names, fields, width)
    type(string_t), intent(in) :: names(:)
    !> length width * size(names)
    character(:), allocatable, intent(out) :: fields
    !> length of the longest name, at least 1
    integer, intent(out) :: width
    integer :: i_name

    width = 1
    do i_name = 1, size(names)
      width = max(width, len(names(i_name)%text))
    end do
    allocate (character(width * size(names)) :: fields)
    do i_name = 1, size(names)
      fields((i_name - 1) * width + 1:i_name * width) = names(i_name)%text
    end do
  end subroutine pack_names

  !> Calls sig_expression_create of expression.h, which describes the arguments. The handle is null unless code is no_fault; explain
  !> makes the message of the last four arguments.
  subroutine call_c(text, names, places, handle, code, position, token, sentence)
    character(*), intent(in) :: text
    type(string_t), intent(in) :: names(:)
    !> place of the value of each name among the values that `evaluate` takes, 1-based
    integer, intent(in) :: places(:)
    type(c_ptr), intent(out) :: handle
    integer(c_int), intent(out) :: code
    integer(c_int), intent(out) :: position
    character(max_message), intent(out) :: token
    character(max_message), intent(out) :: sentence

    character(:), allocatable :: fields
    integer :: width

    token = ''
    sentence = ''
    call pack_names(names, fields, width)
    code = sig_expression_create(text, len(text, c_size_t), fields, int(width, c_size_t), size(names, kind=c_int), &
      int(places - 1, c_int), handle, position, token, sentence, int(max_message, c_size_t))
    call cut_at_null(token)
    call cut_at_null(sentence)
  end subroutine call_c

  pure subroutine cut_at_null(text)
    character(*), intent(inout) :: text
    integer :: position

    position = index(text, c_null_char)
    if (position > 0) text(position:) = ''
  end subroutine cut_at_null

  !> Returns the message for an error code of sig_expression_create, which gave position, token and sentence.
  pure function explain(text, names, code, position, token, sentence) result(message)
    character(*), intent(in) :: text
    !> all names of variables, for the message
    type(string_t), intent(in) :: names(:)
    integer(c_int), intent(in) :: code
    !> 0-based, negative = unknown; the message counts from 1
    integer(c_int), intent(in) :: position
    !> the name that is unknown or not allowed
    character(*), intent(in) :: token
    !> the parser's message; used for errors of syntax only
    character(*), intent(in) :: sentence
    character(:), allocatable :: message
    character(:), allocatable :: place

    place = ''
    if (position >= 0 .and. position < len_trim(text)) place = ' (character ' // to_text(int(position) + 1) // ')'
    select case (code)
    case (unknown_name)
      message = explain_unknown(names, token, place)
    case (bad_syntax)
      message = sentence // place
    case (several_values)
      message = 'the expression gives more than one value'
    case (bad_name)
      message = 'the variable name ''' // token // ''' is not allowed in an expression'
    case default
      message = 'out of memory'
    end select
  end function explain

  !> Returns the message for a word `token` that is not among the names: the known names, and a similar name or function if there is
  !> one. For the name of a function it says that arguments are needed.
  pure function explain_unknown(names, token, place) result(message)
    type(string_t), intent(in) :: names(:)
    character(*), intent(in) :: token
    !> where the word stands, such as ` (character 5)`; may be empty
    character(*), intent(in) :: place
    character(:), allocatable :: message
    type(string_t), allocatable :: known(:), functions(:)
    character(:), allocatable :: guess
    integer :: i

    if (is_function_name(token)) then
      message = 'the function ''' // token // ''' needs its arguments in parentheses' // place
      return
    end if
    message = 'unknown name ''' // token // '''' // place
    if (size(names) > 0) message = message // '; known: ' // join(names, ', ')
    ! not [names, function_names()]: gfortran 12 never frees such a piece of a constructor
    known = names
    functions = function_names()
    do i = 1, size(functions)
      call append_text(known, functions(i)%text)
    end do
    guess = did_you_mean(token, known)
    if (len(guess) > 0) message = message // '; did you mean ''' // guess // '''?'
  end function explain_unknown
end module sig_expression
