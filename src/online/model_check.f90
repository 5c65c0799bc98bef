! SPDX-License-Identifier: BSD-3-Clause
!> Whether the parts of a model fit together.
module sig_model_check
  use sig_bits, only: n_words
  use sig_model, only: enrichment_history_t, full_order_t, model_t, reduced_model_t, validation_statistics_t
  use sig_term_set, only: source_expression, source_places, source_surface, term_set_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: find_mismatch

contains

  !> Name of a part whose shape does not fit the others; empty when all fit.
  !>
  !> Requires: complete_model.
  pure function find_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name
    integer :: i_cluster, n_parameters

    name = ''
    n_parameters = size(model%parameter_names)
    if (.not. are_consistent(model%terms, model%n_dim)) name = 'terms'
    if (size(model%clusters) < 1) name = 'clusters'
    if (size(model%parameter_units) /= n_parameters) name = 'parameter_units'
    if (any(shape(model%box) /= [2, n_parameters])) name = 'box'
    if (size(model%training_points, 1) /= n_parameters) name = 'training_points'
    if (any(shape(model%gap) /= [model%n_multipliers, model%terms%n_terms()])) name = 'gap'
    if (all(size(model%node_tags) /= [0, model%n_nodes])) name = 'node_tags'
    if (size(model%coordinates, 2) /= size(model%node_tags) .or. size(model%coordinates, 1) /= model%n_dim) name = 'coordinates'
    if (size(model%first_node_tags) /= model%n_multipliers) name = 'first_node_tags'
    if (size(model%second_node_tags) /= model%n_multipliers) name = 'second_node_tags'
    if (any(shape(model%first_coordinates) /= [model%n_dim, model%n_multipliers])) name = 'first_coordinates'
    if (any(shape(model%second_coordinates) /= [model%n_dim, model%n_multipliers])) name = 'second_coordinates'
    if (.not. fits(model%full_order, model%n_multipliers, model%terms%n_terms(), model%n_dofs)) name = 'full_order'
    if (.not. is_consistent(model%validation)) name = 'validation'
    if (.not. model%choice%fits(size(model%clusters), n_parameters)) name = 'choice'
    do i_cluster = 1, size(model%clusters)
      if (len(name) > 0) return
      name = find_cluster_mismatch(model%clusters(i_cluster), model%n_dofs, model%terms%n_terms(), model%n_multipliers)
      if (len(name) > 0) name = 'clusters/' // to_text(i_cluster) // '/' // name
    end do
  end function find_mismatch

  pure function find_cluster_mismatch(cluster, n_dofs, n_terms, n_multipliers) result(name)
    type(reduced_model_t), intent(in) :: cluster
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_multipliers
    character(:), allocatable :: name
    integer :: n_values

    name = ''
    n_values = size(cluster%contact_displacement_snapshots, 1)
    associate (n_modes => cluster%n_modes, n_rows => cluster%n_rows)
      if (any(shape(cluster%basis) /= [n_dofs, n_modes])) name = 'basis'
      if (size(cluster%lifting, 1) /= n_dofs .or. size(cluster%lifting, 2) > n_terms) name = 'lifting'
      if (any(shape(cluster%reduced_stiffness) /= [n_modes, n_modes])) name = 'reduced_stiffness'
      if (any(shape(cluster%contact_matrix) /= [n_rows, n_modes])) name = 'contact_matrix'
      if (any(shape(cluster%load) /= [n_modes, n_terms])) name = 'load'
      if (any(shape(cluster%gap) /= [n_rows, n_terms])) name = 'gap'
      if (size(cluster%contact_rows) /= n_rows) name = 'contact_rows'
      if (any(cluster%contact_rows < 1) .or. any(cluster%contact_rows > n_multipliers)) name = 'contact_rows'
      if (size(cluster%start_sets, 1) /= n_words(n_rows)) name = 'start_sets'
      if (size(cluster%dual_snapshots, 1) /= n_multipliers) name = 'dual_snapshots'
      if (.not. is_whole(cluster%history)) name = 'enrichment'
      if (n_values == 0) return
      if (size(cluster%contact_displacement_snapshots, 2) /= size(cluster%dual_snapshots, 2)) &
        name = 'contact_displacement_snapshots'
      if (any(shape(cluster%contact_value_basis) /= [n_values, n_modes])) name = 'contact_value_basis'
      if (any(shape(cluster%contact_value_lifting) /= [n_values, size(cluster%lifting, 2)])) &
        name = 'contact_value_lifting'
    end associate
  end function find_cluster_mismatch

  pure logical function fits(full_order, n_multipliers, n_terms, n_dofs)
    type(full_order_t), intent(in) :: full_order
    integer, intent(in) :: n_multipliers
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_dofs

    fits = .true.
    if (.not. full_order%has_multipliers()) return
    fits = all(shape(full_order%compliance) == n_multipliers) .and. &
      all(shape(full_order%free_opening) == [n_multipliers, n_terms])
    if (.not. full_order%has_displacement()) return
    fits = fits .and. size(full_order%free_response, 1) == n_dofs .and. size(full_order%free_response, 2) <= n_terms .and. &
      all(shape(full_order%contact_response) == [n_dofs, n_multipliers])
  end function fits

  pure logical function is_whole(history)
    type(enrichment_history_t), intent(in) :: history

    is_whole = all([size(history%nodes), size(history%n_columns), size(history%ranks), size(history%condition_numbers), &
      size(history%singular_ratios), size(history%stiffness_conditions)] == size(history%rows))
  end function is_whole

  !> Indices of the sources point at terms and places that there are.
  pure logical function are_consistent(terms, n_dim)
    type(term_set_t), intent(in) :: terms
    integer, intent(in) :: n_dim
    integer :: i

    are_consistent = terms%n_terms() >= 1
    do i = 1, size(terms%sources)
      associate (source => terms%sources(i))
        are_consistent = are_consistent .and. all(source%terms >= 1 .and. source%terms <= terms%n_terms()) .and. &
          all(source%facets <= size(source%places, 2)) .and. size(source%orientations) == size(source%facets, 2) .and. &
          all(source%dof_terms <= terms%n_terms()) .and. source%component <= n_dim .and. source%axis <= n_dim
        if (source%kind == source_expression) are_consistent = are_consistent .and. size(source%terms) == 1
        if (source%kind == source_places) are_consistent = are_consistent .and. size(source%terms) == size(source%places, 2)
        if (source%kind == source_surface) &
          are_consistent = are_consistent .and. all(shape(source%dof_terms) == shape(source%places))
      end associate
    end do
  end function are_consistent

  pure logical function is_consistent(validation)
    type(validation_statistics_t), intent(in) :: validation

    is_consistent = all([size(validation%minimum), size(validation%median), size(validation%p95), size(validation%maximum)] &
                        == size(validation%names)) .and. size(validation%method_counts) == size(validation%method_names)
  end function is_consistent
end module sig_model_check
