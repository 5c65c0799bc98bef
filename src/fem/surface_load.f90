! SPDX-License-Identifier: BSD-3-Clause
!> Turns pressures and tractions on named surfaces into terms and patterns of nodal forces.
!>
!> If the window does not depend on the parameters, and the value is a sum of products of a function of the parameters and a
!> function of the place, each product has one term; a product without parameters belongs to term 1. Otherwise each loaded dof has
!> a term of its own, whose value is the nodal force.
module sig_surface_load
  use sig_deck_config, only: load_config_t, value_config_t
  use sig_errors, only: error_t, make_error
  use sig_expression, only: expression_t
  use sig_facet_points, only: facet_rule_t, window_t
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  use sig_mesh, only: mesh_t, nodes_of_facet
  use sig_mesh_checks, only: group_of_surface
  use sig_rounding, only: rounding
  use sig_surface_geometry, only: measure_surface, surface_geometry_t
  use sig_term_set, only: source_surface, term_set_t, term_source_t
  use sig_term_values, only: facet_forces
  use sig_text, only: string_t, to_text
  use sig_value_products, only: product_t, split_products
  use sig_window_rule, only: facet_rule
  implicit none(type, external)
  private
  public :: add_surface_load

  !> The pressure of a load, or one component of its traction.
  type :: part_t
    type(load_config_t) :: load
    !> index of the surface in mesh%groups
    integer :: i_group = 0
    !> +1 for facets whose node order gives the outward normal, else -1
    integer, allocatable :: orientations(:)
    !> 0 = pressure, else component of the traction
    integer :: component = 0
    type(value_config_t) :: value
  end type part_t

contains

  !> Adds pressure and traction of a load to terms and pattern. If a value is no sum of products of a function of the parameters and
  !> one of the place, or if a bound of the window is not a number, it gets one term per loaded dof. Otherwise each product gets a
  !> new term, or term 1 if no parameter occurs in it.
  !>
  !> Errors: an unknown surface, or another one that group_of_surface refuses; a facet that is not the side of exactly one cell; a
  !> function of the place that is not finite at an integration point inside of the window. A value that gets one term per loaded
  !> dof is not evaluated here.
  subroutine add_surface_load(mesh, load, deck_path, terms, term_of_dof, pattern, error)
    type(mesh_t), intent(in) :: mesh
    !> pressure, components of a traction [force/length**2] or both, and their window
    type(load_config_t), intent(in) :: load
    !> for messages
    character(*), intent(in) :: deck_path
    !> gets functions of the parameters, or one term per loaded dof (see term_of_dof)
    type(term_set_t), intent(inout) :: terms
    !> for each dof the term that is the force on it, 0 = none yet, shape (n_dofs); all surface loads share these terms
    integer, intent(inout) :: term_of_dof(:)
    !> gets the nodal forces
    type(load_pattern_t), intent(inout) :: pattern
    type(error_t), allocatable, intent(out) :: error
    type(part_t) :: part
    integer :: i_component

    part%load = load
    call group_of_surface(mesh, load%target, deck_path, part%i_group, error)
    if (allocated(error)) return
    call orient_facets(mesh, part%i_group, load, deck_path, part%orientations, error)
    if (allocated(error)) return
    part%value = load%pressure
    if (load%has_pressure) call add_part(mesh, part, deck_path, terms, term_of_dof, pattern, error)
    do i_component = 1, mesh%n_dim
      if (allocated(error)) return
      part%component = i_component
      part%value = load%components(i_component)
      if (load%has_component(i_component)) call add_part(mesh, part, deck_path, terms, term_of_dof, pattern, error)
    end do
  end subroutine add_surface_load

  !> Computes `orientations` of part_t for all facets of the surface. Errors: a facet that is not the side of exactly one cell.
  subroutine orient_facets(mesh, i_group, load, deck_path, orientations, error)
    type(mesh_t), intent(in) :: mesh
    !> index of the surface in mesh%groups
    integer, intent(in) :: i_group
    type(load_config_t), intent(in) :: load
    character(*), intent(in) :: deck_path
    !> +1 for facets whose node order gives the outward normal, else -1; shape (number of facets of the surface)
    integer, allocatable, intent(out) :: orientations(:)
    type(error_t), allocatable, intent(out) :: error
    type(surface_geometry_t) :: geometry
    type(facet_rule_t) :: rule
    integer :: i

    call measure_surface(mesh, i_group, geometry)
    if (geometry%inner_facet > 0) then
      call make_error(error, 'the surface ''' // load%target%text // ''' has a facet, at node ' // &
        to_text(mesh%node_tags(mesh%facet_nodes(mesh%facet_offsets(geometry%inner_facet) + 1))) // &
        ', that is not the side of exactly one cell; a load needs an outer surface', deck_path, load%target%line, &
        load%target%column)
      return
    end if
    associate (facets => mesh%groups(i_group)%entities)
      allocate (orientations(size(facets)))
      do i = 1, size(facets)
        rule = facet_rule(mesh%coordinates(:, nodes_of_facet(mesh, facets(i))), window_t())
        orientations(i) = merge(1, -1, dot_product(sum(rule%area_vectors, dim=2), geometry%area_vectors(:, i)) > 0)
      end do
    end associate
  end subroutine orient_facets

  !> Adds the pressure or one component of the traction to terms and pattern. term_of_dof is that of add_surface_load. Errors: those
  !> of integrate; none for a value that gets one term per dof.
  subroutine add_part(mesh, part, deck_path, terms, term_of_dof, pattern, error)
    type(mesh_t), intent(in) :: mesh
    type(part_t), intent(in) :: part
    character(*), intent(in) :: deck_path
    type(term_set_t), intent(inout) :: terms
    integer, intent(inout) :: term_of_dof(:)
    type(load_pattern_t), intent(inout) :: pattern
    type(error_t), allocatable, intent(out) :: error
    type(product_t), allocatable :: products(:)
    type(part_t) :: factor_of_place
    real(rk) :: forces(mesh%n_dim * mesh%n_nodes)
    integer :: i, i_term
    logical :: is_split

    call split_products(part%value%text, terms%parameter_names, terms%coordinate_names, products, is_split)
    if (.not. (is_split .and. part%load%minimum%is_constant .and. part%load%maximum%is_constant)) then
      call add_dof_terms(mesh, part, terms, term_of_dof, pattern)
      return
    end if
    factor_of_place = part
    do i = 1, size(products)
      i_term = 1
      if (products(i)%of_parameters /= '') &
        call terms%add_expression(products(i)%of_parameters, part%value%line, part%value%column, i_term)
      factor_of_place%value%text = products(i)%of_place
      call integrate(mesh, factor_of_place, terms, deck_path, forces, error)
      if (allocated(error)) return
      call pattern%add_forces(i_term, forces)
    end do
  end subroutine add_part

  !> Computes the nodal forces of a part whose value and window do not depend on the parameters. Errors: its value is not finite at
  !> an integration point inside of the window.
  subroutine integrate(mesh, part, terms, deck_path, forces, error)
    type(mesh_t), intent(in) :: mesh
    type(part_t), intent(in) :: part
    type(term_set_t), intent(in) :: terms
    character(*), intent(in) :: deck_path
    !> [force] shape (n_dofs)
    real(rk), intent(out) :: forces(:)
    type(error_t), allocatable, intent(out) :: error
    type(expression_t) :: expression
    character(:), allocatable :: message
    real(rk), allocatable :: local(:, :)
    integer :: i, k
    logical :: is_valid

    forces = 0
    call expression%create(part%value%text, terms%coordinate_names, message)
    do i = 1, size(mesh%groups(part%i_group)%entities)
      associate (nodes => nodes_of_facet(mesh, mesh%groups(part%i_group)%entities(i)))
        call facet_forces(facet_rule(mesh%coordinates(:, nodes), fixed_window(part%load)), part%component, part%orientations(i), &
          terms%is_round, expression, [real(rk) ::], local, is_valid)
        if (.not. is_valid) then
          call make_error(error, 'the load ''' // part%value%text // ''' is not finite on the facet at node ' // &
            to_text(mesh%node_tags(nodes(1))), deck_path, part%value%line, part%value%column)
          exit
        end if
        do k = 1, mesh%n_dim
          associate (dofs => mesh%n_dim * (nodes - 1) + k)
            forces(dofs) = forces(dofs) + local(k, :)
          end associate
        end do
      end associate
    end do
    call expression%destroy()
  end subroutine integrate

  !> Returns the window of a load whose bounds are constants. A bound that the deck does not give is no bound (see window_t).
  pure type(window_t) function fixed_window(load) result(window)
    type(load_config_t), intent(in) :: load

    window%axis = load%axis
    window%is_cut = load%is_cut
    if (load%has_minimum) window%minimum = load%minimum%constant
    if (load%has_maximum) window%maximum = load%maximum%constant
  end function fixed_window

  !> Adds one term per dof on which the part can act, and a source that computes their values. A dof that already has such a term of
  !> another part keeps it: then both sources add to its value.
  subroutine add_dof_terms(mesh, part, terms, term_of_dof, pattern)
    type(mesh_t), intent(in) :: mesh
    type(part_t), intent(in) :: part
    type(term_set_t), intent(inout) :: terms
    integer, intent(inout) :: term_of_dof(:)
    type(load_pattern_t), intent(inout) :: pattern
    type(term_source_t) :: source
    integer :: i, n, place_of_node(mesh%n_nodes)

    associate (facets => mesh%groups(part%i_group)%entities, nodes => mesh%groups(part%i_group)%nodes)
      place_of_node = 0
      place_of_node(nodes) = [(i, i=1, size(nodes))]
      source%places = mesh%coordinates(:, nodes)
      n = max(4, maxval(mesh%facet_offsets(facets + 1) - mesh%facet_offsets(facets)))
      allocate (source%facets(n, size(facets)), source%dof_terms(mesh%n_dim, size(nodes)), source=0)
      do i = 1, size(facets)
        n = mesh%facet_offsets(facets(i) + 1) - mesh%facet_offsets(facets(i))
        source%facets(:n, i) = place_of_node(nodes_of_facet(mesh, facets(i)))
        call mark_components(source, i, n, part%component)
      end do
      call name_dof_terms(mesh, nodes, terms, term_of_dof, pattern, source%dof_terms)
    end associate
    source%kind = source_surface
    source%text = part%value%text
    source%component = part%component
    source%axis = part%load%axis
    source%is_cut = part%load%is_cut
    source%minimum = ''
    source%maximum = ''
    if (part%load%has_minimum) source%minimum = part%load%minimum%text
    if (part%load%has_maximum) source%maximum = part%load%maximum%text
    source%orientations = part%orientations
    source%line = part%value%line
    source%column = part%value%column
    call terms%add_source(source)
  end subroutine add_dof_terms

  !> Marks the components of a facet's nodes along which the load has a force, by a 1 in source%dof_terms. For a pressure these are
  !> the components that the facet's normals have, wherever the window is.
  pure subroutine mark_components(source, i_facet, n_nodes, component)
    type(term_source_t), intent(inout) :: source
    !> number of the facet in source%facets, 1-based
    integer, intent(in) :: i_facet
    !> number of its nodes
    integer, intent(in) :: n_nodes
    !> 0 = pressure, else component of the traction
    integer, intent(in) :: component
    type(facet_rule_t) :: rule
    integer :: k

    associate (nodes => source%facets(:n_nodes, i_facet))
      if (component > 0) then
        source%dof_terms(component, nodes) = 1
        return
      end if
      rule = facet_rule(source%places(:, nodes), window_t())
      do k = 1, size(source%places, 1)
        if (maxval(abs(rule%area_vectors(k, :))) > rounding * maxval(abs(rule%area_vectors))) &
          source%dof_terms(k, nodes) = 1
      end do
    end associate
  end subroutine mark_components

  !> Replaces each mark in dof_terms by the term that is the force on this dof. All missing terms, and their entries in the pattern,
  !> are added at once, because each addition copies what is there.
  subroutine name_dof_terms(mesh, nodes, terms, term_of_dof, pattern, dof_terms)
    type(mesh_t), intent(in) :: mesh
    !> natural, 1-based
    integer, intent(in) :: nodes(:)
    type(term_set_t), intent(inout) :: terms
    !> as in add_surface_load
    integer, intent(inout) :: term_of_dof(:)
    type(load_pattern_t), intent(inout) :: pattern
    !> in: above 0 where the load can act; out: 1-based terms, 0 elsewhere; shape (n_dim, n_nodes)
    integer, intent(inout) :: dof_terms(:, :)
    type(string_t), allocatable :: names(:)
    integer, allocatable :: new_dofs(:), new_terms(:)
    integer :: dofs(mesh%n_dim, size(nodes)), i, k

    dofs = reshape([((mesh%n_dim * (nodes(i) - 1) + k, k=1, mesh%n_dim), i=1, size(nodes))], shape(dofs))
    new_dofs = pack(dofs, dof_terms > 0)
    new_dofs = pack(new_dofs, term_of_dof(new_dofs) == 0)
    allocate (names(size(new_dofs)), new_terms(size(new_dofs)))
    do i = 1, size(names)
      associate (component => modulo(new_dofs(i) - 1, mesh%n_dim) + 1)
        names(i)%text = 'force along ' // terms%coordinate_names(component)%text // ' on node ' // &
          to_text(mesh%node_tags((new_dofs(i) - 1) / mesh%n_dim + 1))
      end associate
    end do
    call terms%add_terms(names, new_terms)
    call pattern%add_units(new_terms, new_dofs)
    term_of_dof(new_dofs) = new_terms
    do i = 1, size(nodes)
      where (dof_terms(:, i) > 0) dof_terms(:, i) = term_of_dof(dofs(:, i))
    end do
  end subroutine name_dof_terms
end module sig_surface_load
