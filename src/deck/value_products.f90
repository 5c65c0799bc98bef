! SPDX-License-Identifier: BSD-3-Clause
!> Splits an expression into a sum of products of a function of the parameters and a function of the place, so that each product is
!> one term.
module sig_value_products
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: depends_on, max_product, product_t, replace_name, split_products

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
  !> Parentheses are not multiplied out to more products than this; each is a load case.
  integer, parameter :: max_products = 64
  !> characters of a name
  character(*), parameter :: of_names = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789'
  !> after one of these characters a sign belongs to the next operand
  character(*), parameter :: before_sign = ' *(/^+-<>=!&|?:,'

contains

  !> Splits an expression at its operators + - * / into a sum of products. Each product is a factor of the parameters times a factor
  !> of the place. What names neither, such as a number, belongs to the factor of the place. Parentheses that hold both are
  !> multiplied out. An expression of the parameters alone, of the coordinates alone, or of neither is one product. Nothing is split
  !> if an operator such as < or ? stands outside of parentheses: then the whole text is one factor.
  pure recursive subroutine split_products(text, parameter_names, coordinate_names, products, is_split, mixed_factor)
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
    type(product_t), allocatable :: own(:)
    character(:), allocatable :: first_mixed, mixed
    character(len(text)) :: operators
    integer, allocatable :: cuts(:)
    integer :: i

    allocate (products(0))
    first_mixed = ''
    if (.not. (depends_on(text, coordinate_names) .and. depends_on(text, parameter_names))) then
      if (depends_on(text, parameter_names)) then
        call append_product(products, product_t(text, '1'))
      else
        call append_product(products, product_t('', text))
      end if
      is_split = .true.
    else
      operators = find_operators(text)
      cuts = [0, pack([(i, i=1, len(text))], [(scan(operators(i:i), '+-') > 0, i=1, len(text))]), len(text) + 1]
      do i = 1, size(cuts) - 1
        call split_addend(text(cuts(i) + 1:cuts(i + 1) - 1), operators(cuts(i) + 1:cuts(i + 1) - 1), parameter_names, &
          coordinate_names, own, mixed)
        if (cuts(i) > 0) call negate_after(operators(cuts(i):cuts(i)), own)
        if (first_mixed == '') first_mixed = mixed
        call append_products(products, own)
      end do
      is_split = first_mixed == ''
      do i = 1, size(products)
        if (products(i)%of_place == '') products(i)%of_place = '1'
        is_split = is_split .and. max(len(products(i)%of_parameters), len(products(i)%of_place)) <= max_product
      end do
    end if
    if (present(mixed_factor)) mixed_factor = first_mixed
  end subroutine split_products

  !> Splits what stands between two operators + and -. Parts of the products may be empty, which means 1.
  pure recursive subroutine split_addend(addend, signs, parameter_names, coordinate_names, products, mixed)
    character(*), intent(in) :: addend
    !> operators between the factors, at their positions
    character(*), intent(in) :: signs
    type(string_t), intent(in) :: parameter_names(:)
    type(string_t), intent(in) :: coordinate_names(:)
    type(product_t), allocatable, intent(out) :: products(:)
    !> first factor that depends on both and cannot be multiplied out, the whole addend if that gives more than max_products; empty
    !> if there is none
    character(:), allocatable, intent(out) :: mixed
    type(product_t), allocatable :: inner(:)
    character(:), allocatable :: inner_mixed
    integer :: first, last
    character :: sign
    logical :: is_split

    allocate (products(0))
    call append_product(products, product_t('', ''))
    mixed = ''
    sign = '*'
    first = 1
    do while (first <= len(addend))
      last = scan(signs(first:), '*/') + first - 2
      if (last < first) last = len(addend)
      associate (factor => addend(first:last))
        if (.not. depends_on(factor, parameter_names)) then
          call multiply_by(products, sign, product_t('', factor))
        else if (.not. depends_on(factor, coordinate_names)) then
          call multiply_by(products, sign, product_t(factor, ''))
        else if (sign == '*' .and. is_sum(factor)) then
          call split_products(inside(factor), parameter_names, coordinate_names, inner, is_split, inner_mixed)
          if (scan(adjustl(factor), '-') == 1) call negate_after('-', inner)
          if (mixed == '') mixed = inner_mixed
          call multiply_out(products, inner)
        else if (mixed == '') then
          mixed = trim(adjustl(factor))
        end if
      end associate
      if (last < len(addend)) sign = signs(last + 1:last + 1)
      first = last + 2
    end do
    if (mixed == '' .and. size(products) > max_products) mixed = trim(adjustl(addend))
  end subroutine split_addend

  !> Whether the factor is one pair of parentheses, with a sign or without one.
  pure logical function is_sum(factor)
    character(*), intent(in) :: factor
    integer :: depth, first, i

    is_sum = .false.
    first = verify(factor, ' +-')
    if (factor(first:first) /= '(') return
    depth = 0
    do i = first, len_trim(factor)
      if (factor(i:i) == '(') depth = depth + 1
      if (factor(i:i) == ')') depth = depth - 1
      if (depth == 0) exit
    end do
    is_sum = i == len_trim(factor) .and. len_trim(adjustl(factor(:first - 1))) <= 1
  end function is_sum

  !> Returns what stands inside of the parentheses of a factor (is_sum).
  pure function inside(factor) result(text)
    character(*), intent(in) :: factor
    character(:), allocatable :: text

    text = factor(scan(factor, '(') + 1:len_trim(factor) - 1)
  end function inside

  !> Changes the sign of products behind an operator -.
  pure subroutine negate_after(operator, products)
    character, intent(in) :: operator
    type(product_t), intent(inout) :: products(:)
    integer :: i

    if (operator /= '-') return
    do i = 1, size(products)
      if (products(i)%of_place == '') then
        products(i)%of_place = '-1'
      else
        products(i)%of_place = '-1*' // products(i)%of_place
      end if
    end do
  end subroutine negate_after

  !> Replaces products by all products of one of them and one of `inner`.
  pure subroutine multiply_out(products, inner)
    type(product_t), allocatable, intent(inout) :: products(:)
    type(product_t), intent(in) :: inner(:)
    type(product_t), allocatable :: all_products(:), some(:)
    integer :: i

    ! too many already; the caller finds that
    if (size(products) > max_products) return
    allocate (all_products(0))
    do i = 1, size(inner)
      some = products
      call multiply_by(some, '*', inner(i))
      call append_products(all_products, some)
    end do
    call move_alloc(all_products, products)
  end subroutine multiply_out

  !> Multiplies or divides (sign / ) each product by a factor, one part of which may be empty.
  pure subroutine multiply_by(products, sign, factor)
    type(product_t), intent(inout) :: products(:)
    character, intent(in) :: sign
    type(product_t), intent(in) :: factor
    integer :: i

    do i = 1, size(products)
      if (factor%of_parameters /= '') call append_factor(products(i)%of_parameters, sign, factor%of_parameters)
      if (factor%of_place /= '') call append_factor(products(i)%of_place, sign, factor%of_place)
    end do
  end subroutine multiply_by

  pure subroutine append_products(products, more)
    type(product_t), allocatable, intent(inout) :: products(:)
    type(product_t), intent(in) :: more(:)
    integer :: i

    do i = 1, size(more)
      call append_product(products, more(i))
    end do
  end subroutine append_products

  pure subroutine append_product(products, next)
    type(product_t), allocatable, intent(inout) :: products(:)
    type(product_t), intent(in) :: next
    type(product_t), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(products) + 1))
    do i = 1, size(products)
      longer(i) = products(i)
    end do
    longer(size(longer)) = next
    call move_alloc(longer, products)
  end subroutine append_product

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

  !> Returns the text with another one, in parentheses, in place of a name wherever this occurs as a whole word.
  pure function replace_name(text, name, expression) result(replaced)
    character(*), intent(in) :: text, name, expression
    character(:), allocatable :: replaced
    integer :: first, last

    replaced = ''
    first = 1
    do while (first <= len(text))
      last = verify(text(first:), of_names) + first - 2
      if (last < first - 1) last = len(text)
      if (text(first:last) == name .and. last >= first) then
        replaced = replaced // '(' // expression // ')'
      else
        replaced = replaced // text(first:last)
      end if
      ! the character that ends the word
      if (last < len(text)) replaced = replaced // text(last + 1:last + 1)
      first = last + 2
    end do
  end function replace_name

  !> Whether any of the names occurs in the text as a whole word.
  pure logical function depends_on(text, names)
    character(*), intent(in) :: text
    type(string_t), intent(in) :: names(:)
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
