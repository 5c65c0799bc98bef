! SPDX-License-Identifier: BSD-3-Clause
!> Whether the parts of a model fit together, and a hash of all of them.
module sig_model_check
  use sig_checksum, only: fnv1a, fnv1a_seed, hash_digits
  use sig_kinds, only: lk, rk
  use sig_model, only: model_t, reduced_model_t, validation_statistics_t
  use sig_term_set, only: source_expression, source_places, source_surface, term_set_t, term_source_t
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: find_mismatch, hash_of_model

  !> Adds a part, with its shape, to a hash.
  interface add
    procedure add_text, add_texts, add_integers, add_reals, add_matrix
  end interface add

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
    if (size(model%first_node_tags) /= model%n_multipliers) name = 'first_node_tags'
    if (size(model%second_node_tags) /= model%n_multipliers) name = 'second_node_tags'
    if (any(shape(model%first_coordinates) /= [model%n_dim, model%n_multipliers])) name = 'first_coordinates'
    if (any(shape(model%second_coordinates) /= [model%n_dim, model%n_multipliers])) name = 'second_coordinates'
    if (.not. is_consistent(model%validation)) name = 'validation'
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
      if (size(cluster%dual_snapshots, 1) /= n_multipliers) name = 'dual_snapshots'
      if (n_values == 0) return
      if (size(cluster%contact_displacement_snapshots, 2) /= size(cluster%dual_snapshots, 2)) &
        name = 'contact_displacement_snapshots'
      if (any(shape(cluster%contact_value_basis) /= [n_values, n_modes])) name = 'contact_value_basis'
      if (any(shape(cluster%contact_value_lifting) /= [n_values, size(cluster%lifting, 2)])) &
        name = 'contact_value_lifting'
    end associate
  end function find_cluster_mismatch

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
                        == size(validation%names))
  end function is_consistent

  !> 16 hexadecimal digits over everything that the file holds, shapes included.
  !>
  !> Requires: complete_model.
  pure function hash_of_model(model) result(digits)
    type(model_t), intent(in) :: model
    character(16) :: digits
    integer(lk) :: hash
    integer :: i_cluster

    hash = fnv1a_seed
    call add(hash, model%code_version)
    call add(hash, model%deck_text)
    call add(hash, model%title)
    call add(hash, model%provenance)
    call add(hash, model%mesh_hash)
    call add(hash, model%length_unit)
    call add(hash, model%force_unit)
    call add(hash, model%parameter_names)
    call add(hash, model%parameter_units)
    call add(hash, model%box)
    call add(hash, model%training_points)
    call add_terms(hash, model%terms)
    call add(hash, [model%n_nodes, model%n_dofs, model%n_dim, model%n_multipliers])
    call add(hash, model%first_node_tags)
    call add(hash, model%second_node_tags)
    call add(hash, model%first_coordinates)
    call add(hash, model%second_coordinates)
    call add(hash, model%gap)
    call add(hash, [model%pod_tolerance])
    call add(hash, model%dirichlet)
    call add(hash, model%reconstruction)
    do i_cluster = 1, size(model%clusters)
      call add_cluster(hash, model%clusters(i_cluster))
    end do
    call add(hash, model%validation%names)
    call add(hash, model%validation%minimum)
    call add(hash, model%validation%median)
    call add(hash, model%validation%p95)
    call add(hash, model%validation%maximum)
    digits = hash_digits(hash)
  end function hash_of_model

  pure subroutine add_terms(hash, terms)
    integer(lk), intent(inout) :: hash
    type(term_set_t), intent(in) :: terms
    integer :: i

    call add(hash, terms%names)
    call add(hash, terms%coordinate_names)
    call add(hash, [merge(1, 0, terms%is_round)])
    do i = 1, size(terms%sources)
      call add_source(hash, terms%sources(i))
    end do
  end subroutine add_terms

  pure subroutine add_source(hash, source)
    integer(lk), intent(inout) :: hash
    type(term_source_t), intent(in) :: source

    call add(hash, [source%kind, source%component, source%axis, merge(1, 0, source%is_cut)])
    call add(hash, source%text)
    call add(hash, source%minimum)
    call add(hash, source%maximum)
    call add(hash, source%terms)
    call add(hash, source%places)
    call add(hash, reshape(source%facets, [size(source%facets)]))
    call add(hash, source%orientations)
    call add(hash, reshape(source%dof_terms, [size(source%dof_terms)]))
  end subroutine add_source

  pure subroutine add_cluster(hash, cluster)
    integer(lk), intent(inout) :: hash
    type(reduced_model_t), intent(in) :: cluster

    call add(hash, [cluster%n_modes, cluster%n_rows, cluster%rank, cluster%primal_rank_expected])
    call add(hash, [cluster%condition_number, cluster%stiffness_condition])
    call add(hash, cluster%basis)
    call add(hash, cluster%lifting)
    call add(hash, cluster%reduced_stiffness)
    call add(hash, cluster%contact_matrix)
    call add(hash, cluster%load)
    call add(hash, cluster%gap)
    call add(hash, cluster%contact_rows)
    call add(hash, cluster%seed_nodes)
    call add(hash, cluster%facing_nodes)
    call add(hash, cluster%cells)
    call add(hash, cluster%interior_dofs)
    call add(hash, cluster%interface_dofs)
    call add(hash, cluster%contact_dofs)
    call add(hash, cluster%dual_snapshots)
    call add(hash, cluster%contact_displacement_snapshots)
    call add(hash, cluster%contact_value_basis)
    call add(hash, cluster%contact_value_lifting)
    call add(hash, cluster%singular_values)
    call add(hash, cluster%warnings)
  end subroutine add_cluster

  pure subroutine add_text(hash, text)
    integer(lk), intent(inout) :: hash
    character(*), intent(in) :: text

    hash = fnv1a(text, fnv1a([len(text)], hash))
  end subroutine add_text

  pure subroutine add_texts(hash, texts)
    integer(lk), intent(inout) :: hash
    type(string_t), intent(in) :: texts(:)
    integer :: i_text

    hash = fnv1a([size(texts)], hash)
    do i_text = 1, size(texts)
      call add_text(hash, texts(i_text)%text)
    end do
  end subroutine add_texts

  pure subroutine add_integers(hash, values)
    integer(lk), intent(inout) :: hash
    integer, intent(in) :: values(:)

    hash = fnv1a(values, fnv1a(shape(values), hash))
  end subroutine add_integers

  pure subroutine add_reals(hash, values)
    integer(lk), intent(inout) :: hash
    real(rk), intent(in) :: values(:)

    hash = fnv1a(values, fnv1a(shape(values), hash))
  end subroutine add_reals

  pure subroutine add_matrix(hash, values)
    integer(lk), intent(inout) :: hash
    real(rk), intent(in) :: values(:, :)

    hash = fnv1a(values, fnv1a(shape(values), hash))
  end subroutine add_matrix
end module sig_model_check
