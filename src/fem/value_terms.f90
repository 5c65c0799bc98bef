! SPDX-License-Identifier: BSD-3-Clause
!> Splits a value of the deck, given at nodes, into terms of the parameters.
module sig_value_terms
  use sig_deck_config, only: value_config_t
  use sig_errors, only: error_t, make_error
  use sig_expression, only: expression_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_term_set, only: source_places, term_set_t, term_source_t
  use sig_text, only: string_t, to_text
  use sig_value_products, only: product_t, split_products
  implicit none(type, external)
  private
  public :: value_terms_t, split_sum

  !> One part of a value: at node k of a list it is factors(k) * theta(terms(k)).
  type :: value_terms_t
    !> index of the term at each node, 1-based
    integer, allocatable :: terms(:)
    real(rk), allocatable :: factors(:)
  end type value_terms_t

contains

  !> Splits a value at nodes into parts; the value at a node is their sum. A value with both parameters and coordinates that is a
  !> sum of products of a function of the parameters and a function of the place has one part per product. Such a part has one new
  !> term, or term 1 if no parameter occurs in the product. Any other value is one part: with term 1 if it has no parameters, with
  !> one new term if it has no coordinates, and else with one new term per node.
  !>
  !> Errors: a function of the place that is not finite at a node. A value with one term per node is not evaluated here.
  subroutine split_sum(mesh, nodes, value, deck_path, terms, parts, error)
    type(mesh_t), intent(in) :: mesh
    !> natural, 1-based
    integer, intent(in) :: nodes(:)
    !> value of the deck: a constant, or an expression of parameters and coordinates
    type(value_config_t), intent(in) :: value
    !> for messages
    character(*), intent(in) :: deck_path
    !> grows by the terms of the value
    type(term_set_t), intent(inout) :: terms
    !> arrays of each part have the shape of nodes
    type(value_terms_t), allocatable, intent(out) :: parts(:)
    type(error_t), allocatable, intent(out) :: error
    type(product_t), allocatable :: products(:)
    type(value_config_t) :: place
    integer :: i, i_term
    logical :: is_split

    is_split = .false.
    if (value%uses_coordinates .and. value%uses_parameters) &
      call split_products(value%text, terms%parameter_names, terms%coordinate_names, products, is_split)
    if (.not. is_split) then
      allocate (parts(1))
      call split_value(mesh, nodes, value, deck_path, terms, parts(1), error)
      return
    end if
    allocate (parts(size(products)))
    place = value
    place%uses_parameters = .false.
    do i = 1, size(products)
      place%text = products(i)%of_place
      call split_value(mesh, nodes, place, deck_path, terms, parts(i), error)
      if (allocated(error)) return
      if (products(i)%of_parameters == '') cycle
      call terms%add_expression(products(i)%of_parameters, value%line, value%column, i_term)
      parts(i)%terms = i_term
    end do
  end subroutine split_sum

  !> Splits a value at nodes into terms. A value without parameters belongs to term 1. A value with parameters but without
  !> coordinates is one new term. A value with both has one new term per node.
  !>
  !> Errors: a value without parameters that is not finite at a node.
  subroutine split_value(mesh, nodes, value, deck_path, terms, parts, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:)
    type(value_config_t), intent(in) :: value
    character(*), intent(in) :: deck_path
    type(term_set_t), intent(inout) :: terms
    type(value_terms_t), intent(out) :: parts
    type(error_t), allocatable, intent(out) :: error
    integer :: i_term

    parts%terms = spread(1, 1, size(nodes))
    parts%factors = spread(1.0_rk, 1, size(nodes))
    if (value%is_constant) then
      parts%factors = value%constant
    else if (.not. value%uses_coordinates) then
      call terms%add_expression(value%text, value%line, value%column, i_term)
      parts%terms = i_term
    else if (.not. value%uses_parameters) then
      call evaluate_on_nodes(mesh, nodes, value, deck_path, terms, parts%factors, error)
    else
      call add_place_terms(mesh, nodes, value, terms, parts%terms)
    end if
  end subroutine split_value

  !> Evaluates an expression of the coordinates at the nodes. Errors: a value that is not finite; the message has the first such
  !> node.
  subroutine evaluate_on_nodes(mesh, nodes, value, deck_path, terms, values, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:)
    type(value_config_t), intent(in) :: value
    character(*), intent(in) :: deck_path
    type(term_set_t), intent(in) :: terms
    !> set up to the first node without a finite value; shape (size(nodes))
    real(rk), intent(inout) :: values(:)
    type(error_t), allocatable, intent(out) :: error
    type(expression_t) :: expression
    character(:), allocatable :: message
    integer :: i
    logical :: is_valid

    call expression%create(value%text, terms%coordinate_names, message, is_composed=.true.)
    do i = 1, size(nodes)
      call expression%evaluate(mesh%coordinates(:, nodes(i)), values(i), is_valid)
      if (is_valid) cycle
      call make_error(error, 'the expression ''' // value%text // ''' is not finite at node ' // &
        to_text(mesh%node_tags(nodes(i))), deck_path, value%line, value%column)
      exit
    end do
    call expression%destroy()
  end subroutine evaluate_on_nodes

  !> Adds one term per node: the value of the expression at the node.
  subroutine add_place_terms(mesh, nodes, value, terms, term_of_node)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:)
    type(value_config_t), intent(in) :: value
    type(term_set_t), intent(inout) :: terms
    !> indices of the new terms, 1-based; shape (size(nodes))
    integer, intent(inout) :: term_of_node(:)
    type(string_t) :: names(size(nodes))
    type(term_source_t) :: source
    character(:), allocatable :: name
    integer :: i

    name = value%text
    if (allocated(value%name)) name = value%name
    do i = 1, size(nodes)
      names(i)%text = name // ' at node ' // to_text(mesh%node_tags(nodes(i)))
    end do
    call terms%add_terms(names, term_of_node)
    source%kind = source_places
    source%text = value%text
    source%terms = term_of_node
    source%places = mesh%coordinates(:, nodes)
    source%line = value%line
    source%column = value%column
    call terms%add_source(source)
  end subroutine add_place_terms
end module sig_value_terms
