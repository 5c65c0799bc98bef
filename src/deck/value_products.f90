! SPDX-License-Identifier: BSD-3-Clause
!> Splits an expression into a sum of products of a function of the parameters and a function of the place, so that each product is
!> one term.
module sig_value_products
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: max_product, product_t, split_products

  !> One product, as two expressions.
  type :: product_t
    !> factor that depends on the parameters; empty if no parameter occurs
    character(:), allocatable :: of_parameters
    !> all other factors: an expression of the coordinates, or of numbers alone
    character(:), allocatable :: of_place
  end type product_t

  !> largest number of characters of of_parameters, and of of_place. Either may be longer than the text in the deck, because each
  !> factor gets parentheses
  integer, parameter :: max_product = 1000
  !> after one of these characters a sign belongs to the next operand
  character(*), parameter :: before_sign = ' *(/^+-<>=!&|?:,'

contains

  !> Splits an expression at its operators + - * / outside of parentheses into a sum of products. Each product is a factor of
  !> the parameters times a factor of the place. What names neither, such as a number, belongs to the factor of the place. An
  !> expression of the parameters alone, of the coordinates alone, or of neither is one product. Nothing is split if an operator
  !> such as < or ? stands outside of parentheses: then the whole text is one factor.
  pure subroutine split_products(text, parameter_names, coordinate_names, products, is_split, mixed_factor)
    !> a valid expression of these names
    character(*), intent(in) :: text
    type(string_t), intent(in) :: parameter_names(:)
    type(string_t), intent(in) :: coordinate_names(:)
    !> must not be used unless is_split
    type(product_t), allocatable, intent(out) :: products(:)
    !> whether no factor depends on both parameters and coordinates, and no text is longer than max_product; always true for an
    !> expression that is one product
    logical, intent(out) :: is_split
    !> first factor that depends on both, as it stands in the text; empty if there is none
    character(:), allocatable, intent(out), optional :: mixed_factor
    character(:), allocatable :: mixed
    character(len(text)) :: operators
    integer, allocatable :: cuts(:)
    integer :: i

    is_split = .true.
    if (present(mixed_factor)) mixed_factor = ''
    if (.not. (depends_on(text, coordinate_names) .and. depends_on(text, parameter_names))) then
      allocate (products(1))
      products(1)%of_parameters = ''
      products(1)%of_place = text
      if (depends_on(text, parameter_names)) then
        products(1)%of_parameters = text
        products(1)%of_place = '1'
      end if
      return
    end if
    operators = find_operators(text)
    cuts = [0, pack([(i, i=1, len(text))], [(scan(operators(i:i), '+-') > 0, i=1, len(text))]), len(text) + 1]
    allocate (products(size(cuts) - 1))
    do i = 1, size(products)
      products(i)%of_parameters = ''
      products(i)%of_place = ''
      if (cuts(i) > 0) then
        if (operators(cuts(i):cuts(i)) == '-') products(i)%of_place = '-1'
      end if
      call collect_factors(text(cuts(i) + 1:cuts(i + 1) - 1), operators(cuts(i) + 1:cuts(i + 1) - 1), parameter_names, &
        coordinate_names, products(i), mixed)
      if (products(i)%of_place == '') products(i)%of_place = '1'
      if (present(mixed_factor)) then
        if (mixed_factor == '') mixed_factor = mixed
      end if
      is_split = is_split .and. mixed == '' .and. max(len(products(i)%of_parameters), len(products(i)%of_place)) <= max_product
    end do
  end subroutine split_products

  pure subroutine collect_factors(addend, signs, parameter_names, coordinate_names, product, mixed)
    character(*), intent(in) :: addend
    !> operators between the factors, at their positions
    character(*), intent(in) :: signs
    type(string_t), intent(in) :: parameter_names(:)
    type(string_t), intent(in) :: coordinate_names(:)
    type(product_t), intent(inout) :: product
    !> first factor that depends on both; empty if there is none
    character(:), allocatable, intent(out) :: mixed
    integer :: first, last
    character :: sign

    mixed = ''
    sign = '*'
    first = 1
    do while (first <= len(addend))
      last = scan(signs(first:), '*/') + first - 2
      if (last < first) last = len(addend)
      if (depends_on(addend(first:last), parameter_names)) then
        call append_factor(product%of_parameters, sign, addend(first:last))
        if (mixed == '' .and. depends_on(addend(first:last), coordinate_names)) mixed = trim(adjustl(addend(first:last)))
      else
        call append_factor(product%of_place, sign, addend(first:last))
      end if
      if (last < len(addend)) sign = signs(last + 1:last + 1)
      first = last + 2
    end do
  end subroutine collect_factors

  pure subroutine append_factor(product, sign, factor)
    character(:), allocatable, intent(inout) :: product
    character, intent(in) :: sign
    character(*), intent(in) :: factor

    if (product == '' .and. sign == '*') then
      product = '(' // trim(adjustl(factor)) // ')'
    else
      if (product == '') product = '1'
      product = product // sign // '(' // trim(adjustl(factor)) // ')'
    end if
  end subroutine append_factor

  !> Returns the operators + - * / outside of parentheses, at their positions in the text, with blanks elsewhere. Signs of operands
  !> and of exponents (1e-3) do not count. All are blank if one of < > = ! & | ? : , stands outside of parentheses.
  pure function find_operators(text) result(operators)
    character(*), intent(in) :: text
    character(len(text)) :: operators
    character :: previous
    integer :: depth, i

    operators = ''
    depth = 0
    previous = ' '
    do i = 1, len(text)
      if (text(i:i) == ')') depth = depth - 1
      if (depth == 0) then
        if (scan(text(i:i), '<>=!&|?:,') > 0) then
          operators = ''
          return
        end if
        if (scan(text(i:i), '*/') > 0) operators(i:i) = text(i:i)
        if (scan(text(i:i), '+-') > 0 .and. scan(previous, before_sign) == 0 .and. .not. ends_in_exponent(text(:i - 1))) &
          operators(i:i) = text(i:i)
      end if
      if (text(i:i) == '(') depth = depth + 1
      if (text(i:i) /= ' ') previous = text(i:i)
    end do
  end function find_operators

  !> Whether the text ends with a number and e or E, such as the `1.5e` of 1.5e-3, and not with a name such as h1e.
  pure logical function ends_in_exponent(head)
    character(*), intent(in) :: head
    integer :: before

    ends_in_exponent = .false.
    if (len(head) < 2) return
    if (scan(head(len(head):), 'eE') == 0) return
    before = verify(head(:len(head) - 1), '0123456789.', back=.true.)
    ends_in_exponent = before < len(head) - 1
    if (ends_in_exponent .and. before > 0) ends_in_exponent = scan(head(before:before), '+-*/^(, ') > 0
  end function ends_in_exponent

  !> Whether any of the names occurs in the text as a whole word.
  pure logical function depends_on(text, names)
    character(*), intent(in) :: text
    type(string_t), intent(in) :: names(:)
    character(*), parameter :: of_names = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789'
    integer :: first, i, last

    depends_on = .false.
    first = 1
    do while (first <= len(text))
      last = verify(text(first:), of_names) + first - 2
      if (last < first - 1) last = len(text)
      do i = 1, size(names)
        depends_on = depends_on .or. text(first:last) == names(i)%text
      end do
      first = last + 2
    end do
  end function depends_on
end module sig_value_products
