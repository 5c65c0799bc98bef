! SPDX-License-Identifier: BSD-3-Clause
!> Whether the parts of a model fit together, so that no query and no description can go wrong in them.
module sig_model_check
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_bits, only: n_words
  use sig_expression, only: is_identifier
  use sig_kinds, only: rk
  use sig_model, only: contact_side_t, enrichment_history_t, full_order_t, model_t, reduced_model_t, validation_statistics_t
  use sig_term_check, only: are_sound_terms
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: find_mismatch

contains

  !> Name of a part whose shape does not fit the others, or whose values a query cannot work with; empty when all fit.
  !>
  !> A model may come from anywhere: whatever indexes an array, or sends a loop round, is looked at here once.
  !> Requires: complete_model.
  pure function find_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name
    integer :: i_cluster

    name = ''
    if (size(model%clusters) < 1) name = 'clusters'
    if (.not. are_sound_terms(model%terms, model%n_dim)) name = 'terms'
    if (.not. is_consistent(model%validation)) name = 'validation'
    if (len(name) == 0) name = find_size_mismatch(model)
    if (len(name) == 0) name = find_parameter_mismatch(model)
    if (len(name) == 0) name = find_contact_mismatch(model)
    if (len(name) > 0) return
    if (.not. fits(model%full_order, model%n_multipliers, model%terms%n_terms(), model%n_dofs)) name = 'full_order'
    if (.not. model%choice%fits(size(model%clusters), size(model%parameter_names))) name = 'choice'
    do i_cluster = 1, size(model%clusters)
      if (len(name) > 0) return
      name = find_cluster_mismatch(model, model%clusters(i_cluster))
      if (len(name) > 0) name = 'clusters/' // to_text(i_cluster) // '/' // name
    end do
  end function find_mismatch

  pure function find_size_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name
    integer :: i

    name = ''
    if (model%n_dim /= 2 .and. model%n_dim /= 3) name = 'n_dim'
    if (model%n_nodes < 0) name = 'n_nodes'
    if (model%n_multipliers < 0) name = 'n_multipliers'
    if (len(name) > 0) return
    if (model%n_dofs / model%n_dim /= model%n_nodes .or. modulo(model%n_dofs, model%n_dim) /= 0) name = 'n_dofs'
    ! a number alone may be any: there is a field of this size
    if (model%n_dofs > 0 .and. all([(size(model%clusters(i)%basis, 2) + size(model%clusters(i)%lifting, 2) == 0, &
      i=1, size(model%clusters))])) name = 'n_dofs'
    if (all(size(model%node_tags) /= [0, model%n_nodes])) name = 'node_tags'
    if (size(model%coordinates, 2) /= size(model%node_tags) .or. size(model%coordinates, 1) /= model%n_dim) name = 'coordinates'
  end function find_size_mismatch

  pure function find_parameter_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name
    integer :: i, n_parameters

    name = ''
    n_parameters = size(model%parameter_names)
    do i = 1, n_parameters
      if (.not. is_identifier(model%parameter_names(i)%text)) name = 'parameter_names'
    end do
    if (size(model%parameter_units) /= n_parameters) name = 'parameter_units'
    if (any(shape(model%box) /= [2, n_parameters])) name = 'box'
    if (size(model%training_points, 1) /= n_parameters .or. .not. all(ieee_is_finite(model%training_points))) &
      name = 'training_points'
    if (len(name) > 0) return
    if (.not. all(ieee_is_finite(model%box)) .or. any(model%box(1, :) > model%box(2, :))) name = 'box'
  end function find_parameter_mismatch

  pure function find_contact_mismatch(model) result(name)
    type(model_t), intent(in) :: model
    character(:), allocatable :: name

    name = ''
    if (.not. is_matrix(model%gap, model%n_multipliers, model%terms%n_terms())) name = 'gap'
    if (size(model%areas) /= model%n_multipliers .or. .not. all(ieee_is_finite(model%areas))) name = 'contact/areas'
    if (.not. is_side(model%first_side, 1, model%n_multipliers, model%n_dim)) name = 'contact/first'
    if (.not. is_side(model%second_side, 0, model%n_multipliers, model%n_dim)) name = 'contact/second'
  end function find_contact_mismatch

  !> The lists of nodes follow one another and have their coordinates.
  pure logical function is_side(side, n_least, n_multipliers, n_dim)
    type(contact_side_t), intent(in) :: side
    !> nodes of each contact at least
    integer, intent(in) :: n_least
    integer, intent(in) :: n_multipliers
    integer, intent(in) :: n_dim

    is_side = .false.
    associate (starts => side%starts)
      ! sums of numbers that may be any could overflow
      if (size(starts) - 1 /= n_multipliers) return
      if (any(starts < 0 .or. starts > size(side%tags)) .or. starts(1) /= 0 .or. starts(size(starts)) /= size(side%tags)) return
      is_side = all(starts(2:) - starts(:n_multipliers) >= n_least) .and. size(side%weights) == size(side%tags) .and. &
        all(ieee_is_finite(side%weights)) .and. is_matrix(side%coordinates, n_dim, size(side%tags))
    end associate
  end function is_side

  pure function find_cluster_mismatch(model, cluster) result(name)
    type(model_t), intent(in) :: model
    type(reduced_model_t), intent(in) :: cluster
    character(:), allocatable :: name

    name = ''
    associate (n_modes => cluster%n_modes, n_rows => cluster%n_rows, n_terms => model%terms%n_terms())
      if (.not. is_matrix(cluster%basis, model%n_dofs, n_modes)) name = 'basis'
      if (.not. is_matrix(cluster%lifting, model%n_dofs, min(n_terms, size(cluster%lifting, 2)))) name = 'lifting'
      if (.not. is_matrix(cluster%reduced_stiffness, n_modes, n_modes)) name = 'reduced_stiffness'
      if (.not. is_matrix(cluster%contact_matrix, n_rows, n_modes)) name = 'contact_matrix'
      if (.not. is_matrix(cluster%load, n_modes, n_terms)) name = 'load'
      if (.not. is_matrix(cluster%gap, n_rows, n_terms)) name = 'gap'
      if (size(cluster%start_sets, 1) /= n_words(n_rows)) name = 'start_sets'
      if (.not. are_indices(cluster%contact_rows, model%n_multipliers) .or. .not. is_ascending(cluster%contact_rows)) &
        name = 'contact_rows'
    end associate
    if (.not. are_indices(cluster%cells, huge(0))) name = 'cells'
    if (.not. are_indices(cluster%interior_dofs, model%n_dofs)) name = 'interior_dofs'
    if (.not. are_indices(cluster%interface_dofs, model%n_dofs)) name = 'interface_dofs'
    if (.not. are_indices(cluster%contact_dofs, model%n_dofs)) name = 'contact_dofs'
    if (.not. are_indices(cluster%training_points, size(model%training_points, 2))) name = 'training_points'
    if (.not. is_whole(cluster%history)) name = 'enrichment'
    if (len(name) == 0) name = find_snapshot_mismatch(model, cluster)
  end function find_cluster_mismatch

  !> What multipliers outside the domain are made of.
  pure function find_snapshot_mismatch(model, cluster) result(name)
    type(model_t), intent(in) :: model
    type(reduced_model_t), intent(in) :: cluster
    character(:), allocatable :: name

    name = ''
    associate (n_values => size(cluster%contact_displacement_snapshots, 1), n_snapshots => size(cluster%dual_snapshots, 2))
      if (.not. is_matrix(cluster%dual_snapshots, model%n_multipliers, n_snapshots)) name = 'dual_snapshots'
      if (n_values == 0) return
      if (.not. is_matrix(cluster%contact_displacement_snapshots, n_values, n_snapshots)) name = 'contact_displacement_snapshots'
      if (.not. is_matrix(cluster%contact_value_basis, n_values, cluster%n_modes)) name = 'contact_value_basis'
      if (.not. is_matrix(cluster%contact_value_lifting, n_values, size(cluster%lifting, 2))) name = 'contact_value_lifting'
    end associate
  end function find_snapshot_mismatch

  !> Of this shape, and without infinite values.
  pure logical function is_matrix(values, n_rows, n_columns)
    real(rk), intent(in) :: values(:, :)
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_columns

    is_matrix = all(shape(values) == [n_rows, n_columns]) .and. all(ieee_is_finite(values))
  end function is_matrix

  !> Between 1 and n.
  pure logical function are_indices(values, n)
    integer, intent(in) :: values(:)
    integer, intent(in) :: n

    are_indices = all(values >= 1 .and. values <= n)
  end function are_indices

  pure logical function is_ascending(values)
    integer, intent(in) :: values(:)

    is_ascending = all(values(2:) > values(:size(values) - 1))
  end function is_ascending

  pure logical function fits(full_order, n_multipliers, n_terms, n_dofs)
    type(full_order_t), intent(in) :: full_order
    integer, intent(in) :: n_multipliers
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_dofs

    fits = .true.
    if (.not. full_order%has_multipliers()) return
    fits = is_matrix(full_order%compliance, n_multipliers, n_multipliers) .and. &
      is_matrix(full_order%free_opening, n_multipliers, n_terms)
    if (.not. full_order%has_displacement()) return
    fits = fits .and. is_matrix(full_order%free_response, n_dofs, min(n_terms, size(full_order%free_response, 2))) .and. &
      is_matrix(full_order%contact_response, n_dofs, n_multipliers)
  end function fits

  pure logical function is_whole(history)
    type(enrichment_history_t), intent(in) :: history

    is_whole = all([size(history%nodes), size(history%n_columns), size(history%ranks), size(history%condition_numbers), &
      size(history%singular_ratios), size(history%stiffness_conditions)] == size(history%rows))
  end function is_whole

  pure logical function is_consistent(validation)
    type(validation_statistics_t), intent(in) :: validation

    is_consistent = all([size(validation%minimum), size(validation%median), size(validation%p95), size(validation%maximum)] &
                        == size(validation%names)) .and. size(validation%method_counts) == size(validation%method_names)
  end function is_consistent
end module sig_model_check
