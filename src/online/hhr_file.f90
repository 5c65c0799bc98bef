! SPDX-License-Identifier: BSD-3-Clause
!> Writes and reads a hyper-reduced model as a group of an HDF5 file, or as bytes for another rank, and checks what was read.
module sig_hhr_file
  use sig_bits, only: n_words
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_hhr_data, only: enrichment_history_t, hhr_data_t
  use sig_model_data, only: model_sizes_t
  use sig_shape_checks, only: are_indices, is_ascending, is_matrix
  implicit none(type, external)
  private
  public :: write_cluster, read_cluster, pack_cluster, unpack_cluster, find_hhr_mismatch

  !> name of the only group in a file of bytes
  character(*), parameter :: packed_group = '/cluster'

contains

  !> Packs a cluster into bytes, from which unpack_cluster makes the same cluster; arrays of `varying` and of `certificate` are not
  !> allocated there if the cluster has no such data. Errors: HDF5 cannot make the file in memory.
  !>
  !> Requires: complete_cluster.
  subroutine pack_cluster(cluster, bytes, error)
    type(hhr_data_t), intent(in) :: cluster
    character(1), allocatable, intent(out) :: bytes(:)
    type(error_t), allocatable, intent(out) :: error
    type(h5_writer_t) :: file

    call file%create_image(error)
    if (allocated(error)) return
    ! the units in these bytes are never read
    call write_cluster(file, packed_group, cluster, '', '')
    call file%close_image(bytes, error)
  end subroutine pack_cluster

  !> Makes a cluster from the bytes of pack_cluster. Errors: the bytes are not an HDF5 file, or a dataset is missing, or has another
  !> type or rank.
  subroutine unpack_cluster(bytes, cluster, error)
    character(1), intent(in) :: bytes(:)
    type(hhr_data_t), intent(out) :: cluster
    type(error_t), allocatable, intent(out) :: error
    type(h5_reader_t) :: file

    call file%open_image(bytes, error)
    call read_cluster(file, packed_group, cluster, error)
    call file%close()
  end subroutine unpack_cluster

  !> Writes a cluster to a group of a file. A failure of the file is reported when the file is closed. Requires: complete_cluster.
  subroutine write_cluster(file, group, cluster, length, force)
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    type(hhr_data_t), intent(in) :: cluster
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/basis', cluster%basis, '1', 'displacement of all dofs, a mode per row')
    call file%write(group // '/lifting', cluster%lifting, length, 'displacement of the lifted terms, a term per row')
    call file%write(group // '/lifted_terms', cluster%lifted_terms, description='terms (1-based) that have a lifting')
    call file%write(group // '/reduced_stiffness', cluster%reduced_stiffness, force // '/' // length, &
      'reduced stiffness, transposed; without the parts of moduli that depend on the parameters')
    call file%write(group // '/contact_matrix', cluster%contact_matrix, '1', 'closing of each contact row by the modes, a ' // &
      'mode per row')
    call file%write(group // '/load', cluster%load, force, 'work of the loads on the modes, a term per row')
    call file%write(group // '/gap', cluster%gap, length, 'right-hand side of the contact rows, a term per row')
    call file%write(group // '/anchors', cluster%anchors, description= &
      'contact rows that hold bodies which nothing else holds, 1-based among those of the part')
    call file%write(group // '/contact_rows', cluster%contact_rows, description='contact rows of the domain: their numbers ' // &
      '(1-based) among the contacts of /contact')
    call file%write(group // '/seed_nodes', cluster%seed_nodes, description='nodes (1-based) that the domain was built around')
    call file%write(group // '/facing_nodes', cluster%facing_nodes, description='nodes (1-based) that face the seed ' // &
      'nodes across contacts')
    call file%write(group // '/training_points', cluster%training_points, description='training points (1-based) of the ' // &
      'snapshots of the cluster')
    call file%write(group // '/cells', cluster%cells, description='cells (1-based) of the reduced integration domain')
    call file%write(group // '/interior_dofs', cluster%interior_dofs, description='dofs (1-based) with an equation')
    call file%write(group // '/interface_dofs', cluster%interface_dofs, description='dofs (1-based) on the border of the ' // &
      'domain, without an equation')
    call file%write(group // '/contact_dofs', cluster%contact_dofs, description='dofs (1-based) of the contact rows')
    call write_snapshots(file, group, cluster, length, force)
    call file%write(group // '@condition_number', cluster%condition_number)
    call file%write(group // '@rank', cluster%rank)
    call file%write(group // '@fits_displacements', merge(1, 0, cluster%fits_displacements))
    call file%write(group // '@stiffness_condition', cluster%stiffness_condition)
    call file%write(group // '@primal_rank_expected', cluster%primal_rank_expected)
    call file%write(group // '@stiffness_rank', cluster%stiffness_rank)
    call file%write(group // '@basis_rank', cluster%basis_rank)
    call file%write(group // '@n_pod_modes', cluster%n_pod_modes)
    call file%write(group // '@n_extra_modes', cluster%n_extra_modes)
    call file%write(group // '@n_hats', cluster%n_hats)
    call write_history(file, group // '/enrichment', cluster%history)
    if (cluster%varying%is_there()) call cluster%varying%write(file, group // '/stiffness', length, force)
    if (cluster%certificate%is_there()) call cluster%certificate%write(file, group // '/certificate', length, force)
  end subroutine write_cluster

  subroutine write_history(file, group, history)
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    type(enrichment_history_t), intent(in) :: history

    call file%write(group // '/rows', history%rows, description='contact row (1-based) of each hat function; the ' // &
      'first entry, 0, stands for the state without hat functions')
    call file%write(group // '/nodes', history%nodes, description='node (1-based) of each hat function')
    call file%write(group // '/n_columns', history%n_columns, description='number of POD modes and hat functions')
    call file%write(group // '/ranks', history%ranks, description='matrix rank of the contact rows after each hat function')
    call file%write(group // '/condition_numbers', history%condition_numbers, '1', 'condition number of the contact rows')
    call file%write(group // '/singular_ratios', history%singular_ratios, '1', &
      'largest singular value of the contact rows over the smallest of the min(rows, columns) ones')
    call file%write(group // '/stiffness_conditions', history%stiffness_conditions, '1', 'condition number of the reduced ' // &
      'stiffness')
  end subroutine write_history

  subroutine write_snapshots(file, group, cluster, length, force)
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    type(hhr_data_t), intent(in) :: cluster
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/dual_snapshots', cluster%dual_snapshots, force, 'contact forces of the snapshots, a snapshot ' // &
      'per row')
    call file%write(group // '/contact_displacement_snapshots', cluster%contact_displacement_snapshots, length, &
      'normal displacements at the contacts, first sides and then second sides, a snapshot per row')
    call file%write(group // '/contact_value_basis', cluster%contact_value_basis, '1', 'normal displacements at the ' // &
      'contacts, a mode per row')
    call file%write(group // '/contact_value_lifting', cluster%contact_value_lifting, length, &
      'normal displacements of the lifting at the contacts, a term per row')
    call file%write(group // '/contact_gap', cluster%contact_gap, length, 'initial gaps of all contacts, a term per row')
    call file%write(group // '/motion_closing', cluster%motion_closing, '1', &
      'closing of each contact by the rigid motions that only contact holds, a motion per row')
    call file%write(group // '/motion_load', cluster%motion_load, force, 'work of the loads on the motions of ' // &
      'motion_closing, a motion per row')
    call file%write(group // '/start_sets', cluster%start_sets, description= &
      'active contact rows of the reduced answer at each training point, a bit per row, 32 to an integer, a point per row')
    call file%write(group // '/singular_values', cluster%singular_values, length, 'singular values of the snapshots ' // &
      '(elastic_lifting: without their response without contact); without unit if the deck normalizes the snapshots')
    call file%write(group // '/warnings', cluster%warnings)
  end subroutine write_snapshots

  !> Reads a cluster from a group of a file. Errors: a dataset or attribute is missing, or has another type or rank. Anchors and
  !> lifted_terms may be missing, as in older files: then there are no anchors, and the lifted terms are the first terms. A cluster
  !> without data for a varying stiffness or for a certificate has no group `stiffness` or `certificate`; their arrays stay
  !> unallocated.
  subroutine read_cluster(file, group, cluster, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(hhr_data_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(inout) :: error
    integer :: fits_displacements, i

    call file%read(group // '/basis', cluster%basis, error)
    call file%read(group // '/lifting', cluster%lifting, error)
    ! older files, whose lifting has no imposed strains, have no lifted_terms; then the lifted terms are the first terms
    if (file%has(group // '/lifted_terms')) call file%read(group // '/lifted_terms', cluster%lifted_terms, error)
    call file%read(group // '/reduced_stiffness', cluster%reduced_stiffness, error)
    call file%read(group // '/contact_matrix', cluster%contact_matrix, error)
    call file%read(group // '/load', cluster%load, error)
    call file%read(group // '/gap', cluster%gap, error)
    if (file%has(group // '/anchors')) call file%read(group // '/anchors', cluster%anchors, error)
    call file%read(group // '/contact_rows', cluster%contact_rows, error)
    call file%read(group // '/seed_nodes', cluster%seed_nodes, error)
    call file%read(group // '/facing_nodes', cluster%facing_nodes, error)
    call file%read(group // '/cells', cluster%cells, error)
    call file%read(group // '/training_points', cluster%training_points, error)
    call file%read(group // '/interior_dofs', cluster%interior_dofs, error)
    call file%read(group // '/interface_dofs', cluster%interface_dofs, error)
    call file%read(group // '/contact_dofs', cluster%contact_dofs, error)
    call read_snapshots(file, group, cluster, error)
    call file%read(group // '@condition_number', cluster%condition_number, error)
    call file%read(group // '@rank', cluster%rank, error)
    call file%read(group // '@fits_displacements', fits_displacements, error)
    cluster%fits_displacements = fits_displacements /= 0
    call file%read(group // '@stiffness_condition', cluster%stiffness_condition, error)
    call file%read(group // '@primal_rank_expected', cluster%primal_rank_expected, error)
    call file%read(group // '@stiffness_rank', cluster%stiffness_rank, error)
    call file%read(group // '@basis_rank', cluster%basis_rank, error)
    call file%read(group // '@n_pod_modes', cluster%n_pod_modes, error)
    call file%read(group // '@n_extra_modes', cluster%n_extra_modes, error)
    call file%read(group // '@n_hats', cluster%n_hats, error)
    call read_history(file, group // '/enrichment', cluster%history, error)
    if (file%has(group // '/stiffness')) call cluster%varying%read(file, group // '/stiffness', error)
    if (file%has(group // '/certificate')) call cluster%certificate%read(file, group // '/certificate', error)
    cluster%n_modes = size(cluster%basis, 2)
    cluster%n_rows = size(cluster%contact_rows)
    if (.not. allocated(cluster%anchors)) allocate (cluster%anchors(0))
    if (.not. allocated(cluster%lifted_terms)) cluster%lifted_terms = [(i, i=1, size(cluster%lifting, 2))]
  end subroutine read_cluster

  subroutine read_history(file, group, history, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(enrichment_history_t), intent(inout) :: history
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/rows', history%rows, error)
    call file%read(group // '/nodes', history%nodes, error)
    call file%read(group // '/n_columns', history%n_columns, error)
    call file%read(group // '/ranks', history%ranks, error)
    call file%read(group // '/condition_numbers', history%condition_numbers, error)
    call file%read(group // '/singular_ratios', history%singular_ratios, error)
    call file%read(group // '/stiffness_conditions', history%stiffness_conditions, error)
  end subroutine read_history

  subroutine read_snapshots(file, group, cluster, error)
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(hhr_data_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/dual_snapshots', cluster%dual_snapshots, error)
    call file%read(group // '/contact_displacement_snapshots', cluster%contact_displacement_snapshots, error)
    call file%read(group // '/contact_value_basis', cluster%contact_value_basis, error)
    call file%read(group // '/contact_value_lifting', cluster%contact_value_lifting, error)
    call file%read(group // '/contact_gap', cluster%contact_gap, error)
    call file%read(group // '/motion_closing', cluster%motion_closing, error)
    call file%read(group // '/motion_load', cluster%motion_load, error)
    call file%read(group // '/start_sets', cluster%start_sets, error)
    call file%read(group // '/singular_values', cluster%singular_values, error)
    call file%read(group // '/warnings', cluster%warnings, error)
  end subroutine read_snapshots

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
end module sig_hhr_file
