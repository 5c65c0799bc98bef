! SPDX-License-Identifier: BSD-3-Clause
!> Turns the section `imposed_strains` of a deck into strains at the integration points of a mesh, as sums of terms.
module sig_strain_parts
  use sig_deck_config, only: deck_config_t, imposed_strain_config_t, material_config_t, value_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_errors, only: error_t, make_error
  use sig_expression, only: expression_t
  use sig_imposed_strain, only: imposed_strains_t, strain_part_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: group_of_region
  use sig_nodal_field, only: nodal_field_t
  use sig_point_values, only: count_points, evaluate_at_points, interpolate_at_points
  use sig_term_set, only: term_set_t
  use sig_text, only: to_text
  use sig_value_products, only: product_t, split_products
  implicit none(type, external)
  private
  public :: create_imposed_strains, find_term, point_product_t, value_products

  !> A product of a function of the parameters, given as an expression (empty: 1), and values at integration points.
  type :: point_product_t
    character(:), allocatable :: of_parameters
    real(rk), allocatable :: values(:)
  end type point_product_t

  !> One entry of the section, for the cells of one material.
  type :: entry_t
    type(imposed_strain_config_t) :: strain
    type(material_config_t) :: material
    character(:), allocatable :: deck_path
    !> nodal values of the entry's file, if it has one
    type(nodal_field_t) :: nodal
  end type entry_t

contains

  !> Creates the imposed strains of the deck. Entries on the same region add up. A region may have several materials.
  !>
  !> Errors: an unknown region, or another one that group_of_region refuses; a temperature on a material without thermal_expansion;
  !> a function of the place that is not finite at an integration point; a product of expressions of the deck that is not valid, for
  !> example because it is too long.
  subroutine create_imposed_strains(mesh, body, deck, fields, strains, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(deck_config_t), intent(in) :: deck
    !> values of the entries' files, not allocated for an entry without a file; shape (size(deck%imposed_strains))
    type(nodal_field_t), intent(in) :: fields(:)
    !> gets parts and terms; start_terms was called for its terms
    type(imposed_strains_t), intent(inout) :: strains
    type(error_t), allocatable, intent(out) :: error
    type(entry_t) :: entry
    type(strain_part_t) :: part
    integer :: i, i_group, i_material

    entry%deck_path = deck%path
    do i = 1, size(deck%imposed_strains)
      entry%strain = deck%imposed_strains(i)
      entry%nodal = fields(i)
      call group_of_region(mesh, entry%strain%region, deck%path, i_group, error)
      if (allocated(error)) return
      do i_material = 1, size(deck%materials)
        entry%material = deck%materials(i_material)
        part%material = i_material
        associate (cells => mesh%groups(i_group)%entities)
          part%cells = pack(cells, body%material_of_cell(cells) == i_material)
        end associate
        if (size(part%cells) > 0) call add_entry(mesh, body, entry, part, strains, error)
        if (allocated(error)) return
      end do
    end do
  end subroutine create_imposed_strains

  !> Adds the parts of one entry in the cells of one material. Errors: as create_imposed_strains, except for the region.
  subroutine add_entry(mesh, body, entry, part, strains, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(entry_t), intent(in) :: entry
    !> has the material and the cells; the rest is work space
    type(strain_part_t), intent(inout) :: part
    type(imposed_strains_t), intent(inout) :: strains
    type(error_t), allocatable, intent(out) :: error
    type(point_product_t), allocatable :: products(:)
    integer :: i

    if (.not. any(entry%strain%has_component)) then
      call isotropic_products(mesh, body, entry, part%cells, strains%terms, products, error)
      if (allocated(error)) return
      part%direction = [real(rk) :: 1, 1, 1, 0, 0, 0]
      call keep_products(products, entry%strain%value, entry%deck_path, part, strains, error)
      return
    end if
    do i = 1, size(entry%strain%components)
      if (.not. entry%strain%has_component(i)) cycle
      call place_products(mesh, body, part%cells, entry%strain%components(i), strains%terms, entry%deck_path, products, error)
      if (allocated(error)) return
      part%direction = 0
      ! the tensor's component of a shear is half the angle
      part%direction(i) = merge(1, 2, i <= 3)
      call keep_products(products, entry%strain%components(i), entry%deck_path, part, strains, error)
      if (allocated(error)) return
    end do
  end subroutine add_entry

  !> Returns the products of an isotropic strain: a swelling, or alpha (T - T_ref). Swelling or T is an expression of the deck; for
  !> an entry with a file it is the factor of the deck times the field of the file, interpolated. Errors: a temperature without
  !> thermal_expansion; an expression whose function of the place is not finite at a point.
  subroutine isotropic_products(mesh, body, entry, cells, terms, products, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(entry_t), intent(in) :: entry
    !> 1-based
    integer, intent(in) :: cells(:)
    !> has the names that expressions may contain
    type(term_set_t), intent(in) :: terms
    type(point_product_t), allocatable, intent(out) :: products(:)
    type(error_t), allocatable, intent(out) :: error

    associate (strain => entry%strain, material => entry%material)
      if (strain%is_thermal .and. .not. material%has_thermal_expansion) then
        call make_error(error, "the region '" // strain%region%text // "' has a temperature, but its material '" // &
          material%name // "' has no thermal_expansion", entry%deck_path, strain%region%line, strain%region%column, &
          'add thermal_expansion to materials.' // material%name)
        return
      end if
      call value_products(mesh, body, strain, entry%nodal, cells, terms, entry%deck_path, products, error)
      if (allocated(error) .or. .not. strain%is_thermal) return
      call add_scaled(products, strain%reference, '', spread(-1.0_rk, 1, count_points(mesh, body, cells)))
      call scale_products(material%thermal_expansion, products)
    end associate
  end subroutine isotropic_products

  !> Returns the products of the temperature or the swelling of an entry: an expression of the deck, or the factor of the deck times
  !> the field of a file, interpolated. Errors: those of place_products.
  subroutine value_products(mesh, body, strain, nodal, cells, terms, deck_path, products, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> has no components
    type(imposed_strain_config_t), intent(in) :: strain
    !> nodal values of the entry's file, if it has one
    type(nodal_field_t), intent(in) :: nodal
    !> 1-based
    integer, intent(in) :: cells(:)
    !> has the names that expressions may contain
    type(term_set_t), intent(in) :: terms
    character(*), intent(in) :: deck_path
    type(point_product_t), allocatable, intent(out) :: products(:)
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: values(:)

    if (strain%has_field) then
      call interpolate_at_points(mesh, body, cells, nodal%values, values)
      allocate (products(0))
      call add_scaled(products, strain%value, '', values)
    else
      call place_products(mesh, body, cells, strain%value, terms, deck_path, products, error)
    end if
  end subroutine value_products

  !> Splits a value into products of a function of the parameters and a function of the place, which is evaluated at the integration
  !> points of the cells. Requires: the value is a sum of such products, as check_products of the deck layer makes sure. Errors: a
  !> function of the place that is not finite at a point.
  subroutine place_products(mesh, body, cells, value, terms, deck_path, products, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: cells(:)
    type(value_config_t), intent(in) :: value
    type(term_set_t), intent(in) :: terms
    character(*), intent(in) :: deck_path
    type(point_product_t), allocatable, intent(out) :: products(:)
    type(error_t), allocatable, intent(out) :: error
    type(product_t), allocatable :: parts(:)
    type(value_config_t) :: place
    real(rk), allocatable :: values(:)
    integer :: bad_cell, i
    logical :: is_split

    allocate (products(0))
    call split_products(value%text, terms%parameter_names, terms%coordinate_names, parts, is_split)
    do i = 1, size(parts)
      place%text = parts(i)%of_place
      call evaluate_at_points(mesh, body, cells, place, terms%coordinate_names, values, bad_cell)
      if (bad_cell > 0) then
        call make_error(error, 'the expression ''' // place%text // ''' is not finite in the element ' // &
          to_text(mesh%cell_tags(bad_cell)), deck_path, value%line, value%column)
        return
      end if
      call add_product(products, parts(i)%of_parameters, values)
    end do
  end subroutine place_products

  !> Adds the product values * factor * of_parameters, as add_product does.
  subroutine add_scaled(products, factor, of_parameters, values)
    type(point_product_t), allocatable, intent(inout) :: products(:)
    !> a number or an expression of the parameters
    type(value_config_t), intent(in) :: factor
    !> expression; empty: 1
    character(*), intent(in) :: of_parameters
    !> at the integration points
    real(rk), intent(in) :: values(:)

    if (factor%is_constant) then
      call add_product(products, of_parameters, factor%constant * values)
    else if (of_parameters == '') then
      call add_product(products, factor%text, values)
    else
      call add_product(products, '(' // factor%text // ')*(' // of_parameters // ')', values)
    end if
  end subroutine add_scaled

  !> Multiplies all products by a factor.
  subroutine scale_products(factor, products)
    !> a number or an expression of the parameters
    type(value_config_t), intent(in) :: factor
    type(point_product_t), allocatable, intent(inout) :: products(:)
    type(point_product_t), allocatable :: scaled(:)
    integer :: i

    allocate (scaled(0))
    do i = 1, size(products)
      call add_scaled(scaled, factor, products(i)%of_parameters, products(i)%values)
    end do
    call move_alloc(scaled, products)
  end subroutine scale_products

  !> Adds a product. If there is one with the same text of the function of the parameters, the values are added to it instead.
  subroutine add_product(products, of_parameters, values)
    type(point_product_t), allocatable, intent(inout) :: products(:)
    !> expression; empty: 1
    character(*), intent(in) :: of_parameters
    !> at the integration points
    real(rk), intent(in) :: values(:)
    type(point_product_t), allocatable :: longer(:)
    integer :: i, n

    n = size(products)
    do i = 1, n
      if (products(i)%of_parameters /= of_parameters) cycle
      products(i)%values = products(i)%values + values
      return
    end do
    allocate (longer(n + 1))
    do i = 1, n
      call move_alloc(products(i)%of_parameters, longer(i)%of_parameters)
      call move_alloc(products(i)%values, longer(i)%values)
    end do
    longer(n + 1)%of_parameters = of_parameters
    longer(n + 1)%values = values
    call move_alloc(longer, products)
  end subroutine add_product

  !> Adds the products of one direction to the strains, each as one part. Errors: as find_term.
  subroutine keep_products(products, value, deck_path, part, strains, error)
    type(point_product_t), intent(in) :: products(:)
    !> for messages
    type(value_config_t), intent(in) :: value
    character(*), intent(in) :: deck_path
    !> has material, cells and direction; the rest is work space
    type(strain_part_t), intent(inout) :: part
    type(imposed_strains_t), intent(inout) :: strains
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    part%line = value%line
    part%column = value%column
    do i = 1, size(products)
      call find_term(strains%terms, 1, products(i)%of_parameters, part, deck_path, part%term, error)
      if (allocated(error)) return
      part%values = products(i)%values
      call strains%add_part(part)
    end do
  end subroutine keep_products

  !> Finds the term with this expression behind the first n_first terms. If there is none, it is added at the end.
  !>
  !> Errors: the text is not a valid expression, as when a product of several expressions of the deck becomes too long.
  subroutine find_term(terms, n_first, text, part, deck_path, i_term, error)
    type(term_set_t), intent(inout) :: terms
    !> number of first terms that are not searched
    integer, intent(in) :: n_first
    !> expression of the parameters; empty: term 1
    character(*), intent(in) :: text
    !> for the place in the deck
    type(strain_part_t), intent(in) :: part
    !> for messages
    character(*), intent(in) :: deck_path
    !> 1-based; of no use after an error
    integer, intent(out) :: i_term
    type(error_t), allocatable, intent(out) :: error
    type(expression_t) :: expression
    character(:), allocatable :: message

    i_term = 1
    if (text == '') return
    do i_term = n_first + 1, terms%n_terms()
      if (terms%names(i_term)%text == text) return
    end do
    call expression%create(text, terms%parameter_names, message)
    call expression%destroy()
    if (allocated(message)) then
      call make_error(error, 'the imposed strain contains the product ''' // text // ''' of expressions of this strain and ' // &
        'its material, which is not valid: ' // message, deck_path, part%line, part%column)
    else
      call terms%add_expression(text, part%line, part%column, i_term)
    end if
  end subroutine find_term
end module sig_strain_parts
