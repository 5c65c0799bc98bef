! SPDX-License-Identifier: BSD-3-Clause
!> Checks that the arrays of a hyper-reduced model fit together.
module sig_hhr_check
  use sig_bits, only: n_words
  use sig_hhr_data, only: enrichment_history_t, hhr_data_t
  use sig_reduced, only: model_sizes_t
  use sig_shape_checks, only: are_indices, is_ascending, is_matrix
  implicit none(type, external)
  private
  public :: find_hhr_mismatch

contains

  !> Returns the name of an array of `cluster` whose shape does not fit the model, or whose values a query cannot use: numbers that
  !> are not finite, indices that do not exist, anchors or contact rows that are not in ascending order. The name is `enrichment`
  !> for the history; it is empty when all fit. Requires: complete_cluster or read_cluster.
  pure function find_hhr_mismatch(cluster, sizes) result(name)
    type(hhr_data_t), intent(in) :: cluster
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = ''
    associate (n_modes => cluster%n_modes, n_rows => cluster%n_rows, n_terms => sizes%n_terms)
      if (.not. is_matrix(cluster%basis, sizes%n_dofs, n_modes)) name = 'basis'
      if (.not. is_matrix(cluster%lifting, sizes%n_dofs, size(cluster%lifted_terms))) name = 'lifting'
      if (.not. are_indices(cluster%lifted_terms, n_terms)) name = 'lifted_terms'
      if (.not. (are_indices(cluster%anchors, n_rows) .and. is_ascending(cluster%anchors))) name = 'anchors'
      if (.not. is_matrix(cluster%reduced_stiffness, n_modes, n_modes)) name = 'reduced_stiffness'
      if (.not. is_matrix(cluster%contact_matrix, n_rows, n_modes)) name = 'contact_matrix'
      if (.not. is_matrix(cluster%load, n_modes, n_terms)) name = 'load'
      if (.not. is_matrix(cluster%gap, n_rows, n_terms)) name = 'gap'
      if (size(cluster%start_sets, 1) /= n_words(n_rows)) name = 'start_sets'
      if (.not. are_indices(cluster%contact_rows, sizes%n_multipliers) .or. .not. is_ascending(cluster%contact_rows)) &
        name = 'contact_rows'
    end associate
    if (.not. are_indices(cluster%cells, huge(0))) name = 'cells'
    if (.not. are_indices(cluster%interior_dofs, sizes%n_dofs)) name = 'interior_dofs'
    if (.not. are_indices(cluster%interface_dofs, sizes%n_dofs)) name = 'interface_dofs'
    if (.not. are_indices(cluster%contact_dofs, sizes%n_dofs)) name = 'contact_dofs'
    if (.not. are_indices(cluster%training_points, sizes%n_points)) name = 'training_points'
    if (.not. is_whole(cluster%history)) name = 'enrichment'
    if (len(name) == 0) name = find_snapshot_mismatch(cluster, sizes)
    if (len(name) == 0) name = cluster%varying%mismatch(sizes%n_terms, cluster%n_modes, size(cluster%lifted_terms))
    if (len(name) == 0) name = cluster%certificate%mismatch(sizes%n_multipliers, sizes%n_terms, &
      size(cluster%dual_snapshots, 2), cluster%n_rows, size(cluster%motion_closing, 2))
  end function find_hhr_mismatch

  !> Does the same as find_hhr_mismatch for the arrays for the multipliers of all contacts: snapshots, openings and rigid motions.
  pure function find_snapshot_mismatch(cluster, sizes) result(name)
    type(hhr_data_t), intent(in) :: cluster
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = ''
    associate (n_values => size(cluster%contact_displacement_snapshots, 1), n_snapshots => size(cluster%dual_snapshots, 2))
      if (.not. is_matrix(cluster%dual_snapshots, sizes%n_multipliers, n_snapshots)) name = 'dual_snapshots'
      if (.not. is_matrix(cluster%contact_gap, sizes%n_multipliers, min(sizes%n_terms, size(cluster%contact_gap, 2)))) &
        name = 'contact_gap'
      associate (n_motions => size(cluster%motion_closing, 2))
        if (.not. is_matrix(cluster%motion_closing, sizes%n_multipliers, n_motions)) name = 'motion_closing'
        if (.not. is_matrix(cluster%motion_load, sizes%n_terms, n_motions)) name = 'motion_load'
      end associate
      if (n_values > 0 .and. .not. is_matrix(cluster%contact_displacement_snapshots, n_values, n_snapshots)) &
        name = 'contact_displacement_snapshots'
      associate (n_basis => max(n_values, size(cluster%contact_value_basis, 1)))
        if (n_basis == 0) return
        if (.not. is_matrix(cluster%contact_value_basis, n_basis, cluster%n_modes)) name = 'contact_value_basis'
        if (.not. is_matrix(cluster%contact_value_lifting, n_basis, size(cluster%lifting, 2))) name = 'contact_value_lifting'
      end associate
    end associate
  end function find_snapshot_mismatch

  !> Whether all arrays of the history have the same length.
  pure logical function is_whole(history)
    type(enrichment_history_t), intent(in) :: history

    is_whole = all([size(history%nodes), size(history%n_columns), size(history%ranks), size(history%condition_numbers), &
      size(history%singular_ratios), size(history%stiffness_conditions)] == size(history%rows))
  end function is_whole
end module sig_hhr_check
