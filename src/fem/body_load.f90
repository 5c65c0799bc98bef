! SPDX-License-Identifier: BSD-3-Clause
!> Turns body forces on named regions into terms and patterns of nodal forces.
module sig_body_load
  use sig_deck_config, only: load_config_t, value_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_element_matrices, only: physical_gradients
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  use sig_mechanical_models, only: circumference
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_mesh_checks, only: group_of_region
  use sig_point_values, only: evaluate_at_points
  use sig_term_set, only: term_set_t
  use sig_text, only: to_text
  use sig_value_products, only: product_t, split_products
  implicit none(type, external)
  private
  public :: add_body_load

contains

  !> Adds a body force to terms and pattern. Each component is a sum of products of a function of the parameters and a function of
  !> the place. The deck layer refuses other expressions. Each product gets a new term, or term 1 if no parameter occurs in it.
  !>
  !> Errors: an unknown region, or another one that group_of_region refuses; a function of the place that is not finite at an
  !> integration point.
  subroutine add_body_load(mesh, body, load, deck_path, terms, pattern, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> body force [force/length**3]
    type(load_config_t), intent(in) :: load
    !> for messages
    character(*), intent(in) :: deck_path
    !> gets the functions of the parameters
    type(term_set_t), intent(inout) :: terms
    !> gets the nodal forces where the function of the parameters is 1
    type(load_pattern_t), intent(inout) :: pattern
    type(error_t), allocatable, intent(out) :: error
    type(product_t), allocatable :: products(:)
    type(value_config_t) :: value
    real(rk) :: forces(mesh%n_dim * mesh%n_nodes)
    real(rk), allocatable :: densities(:)
    integer :: bad_cell, i, i_component, i_group, i_term
    logical :: is_split

    call group_of_region(mesh, load%target, deck_path, i_group, error)
    if (allocated(error)) return
    do i_component = 1, mesh%n_dim
      if (.not. load%has_component(i_component)) cycle
      value = load%components(i_component)
      call split_products(value%text, terms%parameter_names, terms%coordinate_names, products, is_split)
      do i = 1, size(products)
        i_term = 1
        if (products(i)%of_parameters /= '') &
          call terms%add_expression(products(i)%of_parameters, value%line, value%column, i_term)
        value%text = products(i)%of_place
        call evaluate_at_points(mesh, body, mesh%groups(i_group)%entities, value, terms%coordinate_names, densities, bad_cell)
        if (bad_cell > 0) then
          call make_error(error, 'the load ''' // value%text // ''' is not finite in the element ' // &
            to_text(mesh%cell_tags(bad_cell)), deck_path, value%line, value%column)
          return
        end if
        call integrate(mesh, body, mesh%groups(i_group)%entities, i_component, densities, forces)
        call pattern%add_forces(i_term, forces)
      end do
    end do
  end subroutine add_body_load

  !> Computes the nodal forces of a body force along one component: per unit thickness in the plane, over the full turn in
  !> axisymmetry.
  pure subroutine integrate(mesh, body, cells, component, densities, forces)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: cells(:)
    !> 1-based
    integer, intent(in) :: component
    !> [force/length**3] at the integration points of the cells, cell by cell
    real(rk), intent(in) :: densities(:)
    !> [force] shape (n_dofs)
    real(rk), intent(out) :: forces(:)
    real(rk) :: place(mesh%n_dim), volume
    real(rk), allocatable :: gradients(:, :)
    integer :: i, i_point, n

    forces = 0
    n = 0
    do i = 1, size(cells)
      associate (table => body%tables(mesh%cell_types(cells(i))), nodes => nodes_of_cell(mesh, cells(i)))
        if (allocated(gradients)) deallocate (gradients)
        allocate (gradients(mesh%n_dim, size(nodes)))
        do i_point = 1, table%n_points
          n = n + 1
          call physical_gradients(table, i_point, mesh%coordinates(:, nodes), gradients, volume)
          place = matmul(mesh%coordinates(:, nodes), table%values(:, i_point))
          volume = volume * circumference(body%mechanics, place)
          associate (dofs => mesh%n_dim * (nodes - 1) + component)
            forces(dofs) = forces(dofs) + table%values(:, i_point) * volume * densities(n)
          end associate
        end do
      end associate
    end do
  end subroutine integrate
end module sig_body_load
