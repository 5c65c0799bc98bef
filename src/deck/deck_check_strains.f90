! SPDX-License-Identifier: BSD-3-Clause
!> Checks of the entries of the section `imposed_strains`, and of values that must be sums of products.
module sig_deck_check_strains
  use sig_deck_check_values, only: check_field
  use sig_deck_config, only: deck_config_t, value_config_t
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_text, only: to_text
  use sig_value_products, only: max_product, product_t, split_products
  implicit none(type, external)
  private
  public :: check_imposed_strain, check_products

contains

  !> Checks the expressions of one entry of the section imposed_strains. All must be finite, as check_field describes. All but
  !> `reference` (temperature, factor, strain and its components) must also be sums of products, as check_products describes.
  subroutine check_imposed_strain(tree, config, i_strain)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    !> number of the entry, 1-based
    integer, intent(in) :: i_strain
    type(mechanical_model_t) :: model
    character(:), allocatable :: key, path
    integer :: i

    model = mechanical_model(config%mesh%model)
    path = 'imposed_strains[' // to_text(i_strain) // ']'
    associate (strain => config%imposed_strains(i_strain))
      key = '.strain'
      if (strain%is_thermal) key = '.temperature'
      if (strain%has_field) key = '.factor'
      call check_field(tree, path // key, config, strain%value)
      call check_products(tree, path // key, strain%value, 'an imposed ' // key(2:))
      call check_field(tree, path // '.reference', config, strain%reference)
      do i = 1, size(strain%components)
        if (.not. strain%has_component(i)) cycle
        call check_field(tree, path // '.strain.' // trim(model%strain_names(i)), config, strain%components(i))
        call check_products(tree, path // '.strain.' // trim(model%strain_names(i)), strain%components(i), 'an imposed strain')
      end do
    end associate
  end subroutine check_imposed_strain

  !> Checks that a value over a region is a sum of products of a function of the parameters and a function of the place, as
  !> split_products finds them. Otherwise each integration point would need a term of its own. The error names the first factor that
  !> depends on both parameters and place. If there is no such factor, the error is that a product has too many characters.
  subroutine check_products(tree, path, value, noun)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the value
    character(*), intent(in) :: path
    type(value_config_t), intent(in) :: value
    !> name of the value for messages, such as `a body force`
    character(*), intent(in) :: noun
    type(product_t), allocatable :: products(:)
    character(:), allocatable :: factor
    logical :: is_split
    integer :: i, length

    if (.not. (value%uses_parameters .and. value%uses_coordinates)) return
    call split_products(value%text, tree%parameter_names, tree%coordinate_names, products, is_split, factor)
    if (is_split) return
    if (factor == '') then
      length = maxval([(max(len(products(i)%of_parameters), len(products(i)%of_place)), i=1, size(products))])
      call tree%report_at(path, 'has a product that is too long: with parentheses around each, its factors of the parameters, ' // &
        'or those of the place, take ' // to_text(length) // ' characters; at most ' // to_text(max_product) // ' are possible', &
        'powers are shorter: a^3 for a * a * a')
      return
    end if
    call tree%report_at(path, 'is ' // shown(value%text) // '; ' // noun // ' must be a sum of products; ' // &
      'each factor may name parameters or coordinates, but ' // shown(factor) // ' names both', &
      'write sums of products, for example 2 * a^2 * x - (a + 1) * y^2; a function of both, such as ' // &
      'exp(-a * x^2), cannot be used')
  end subroutine check_products
end module sig_deck_check_strains
