! SPDX-License-Identifier: BSD-3-Clause
!> Adds to report.yaml what the stages of a study found.
module sig_reporting
  use sig_body_compliance, only: body_compliance_t
  use sig_compliance, only: compliance_t
  use sig_condensed_model, only: condensed_model_t
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_state, only: contact_state_t, residuals_t
  use sig_deck_config, only: deck_config_t
  use sig_deck_echo, only: echo_deck
  use sig_kinds, only: rk
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_hhr_data, only: hhr_data_t
  use sig_hhr_description, only: hats_text
  use sig_model, only: model_t
  use sig_parameter_space, only: format_point
  use sig_reactions, only: reaction_t
  use sig_reasons, only: reason_converged, reason_text
  use sig_reduced, only: reduced_t
  use sig_reduced_hhr, only: reduced_hhr_t
  use sig_run_report, only: run_report_t
  use sig_selection, only: selection_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_statistics, only: measured_statistics, statistics_t
  use sig_text, only: append_text, counted, csv_number, short_number, string_t, to_text
  use sig_version, only: code_version
  implicit none(type, external)
  private
  public :: report_deck, report_sizes, report_snapshots, report_selection, report_model, report_states, report_reactions
  public :: report_statistics, accuracy_text, model_text, selection_text

  !> names of the rows of the residuals of snapshots
  character(*), parameter :: residual_names(5) = [character(19) :: 'equilibrium', 'penetration', 'negative_multiplier', &
    'complementarity', 'force_balance']

contains

  !> Adds the version of the program and the effective deck.
  subroutine report_deck(deck, report)
    type(deck_config_t), intent(in) :: deck
    type(run_report_t), intent(inout) :: report

    call report%add('version/signorom', code_version)
    call report%add_yaml('deck', echo_deck(deck))
  end subroutine report_deck

  !> Adds the numbers of nodes, cells, dofs, multipliers and inert pairs, and the names of these pairs.
  subroutine report_sizes(n_nodes, n_cells, n_dofs, n_multipliers, inert_pairs, report)
    integer, intent(in) :: n_nodes
    integer, intent(in) :: n_cells
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_multipliers
    !> names of the inert pairs, made of the numbers of their nodes in the mesh file
    type(string_t), intent(in) :: inert_pairs(:)
    type(run_report_t), intent(inout) :: report

    call report%add('sizes/n_nodes', n_nodes)
    call report%add('sizes/n_cells', n_cells)
    call report%add('sizes/n_dofs', n_dofs)
    call report%add('sizes/n_multipliers', n_multipliers)
    call report%add('sizes/n_inert_pairs', size(inert_pairs))
    call report%add('sizes/inert_pairs', inert_pairs)
  end subroutine report_sizes

  !> Adds the number of points, those that did not converge with the reason, the largest value of each residual over all points, and
  !> statistics of the iterations and of the times [s] per point. Points that did not converge count in all of these.
  subroutine report_snapshots(deck, set, report)
    type(deck_config_t), intent(in) :: deck
    type(snapshot_set_t), intent(in) :: set
    type(run_report_t), intent(inout) :: report
    type(string_t), allocatable :: failed(:)
    integer :: i

    call report%add('sampling/n_points', size(set%reasons))
    allocate (failed(0))
    do i = 1, size(set%reasons)
      if (set%reasons(i) == reason_converged) cycle
      call append_text(failed, format_point(deck%state_parameters, set%parameters(:, i)) // ': ' // reason_text(set%reasons(i)))
    end do
    call report%add('sampling/not_converged', failed)
    call report_statistics(report, 'iterations/full_order', real(set%n_iterations, rk))
    do i = 1, size(residual_names)
      call report%add('residuals/' // trim(residual_names(i)), maxval(set%residuals(i, :)))
    end do
    call report_statistics(report, 'times/sample_per_point', set%seconds)
  end subroutine report_snapshots

  !> Adds how a greedy selection of training points ended: indicator, number of points, why it stopped, and the largest indicator
  !> that is left. Requires: the deck has a greedy selection, and it is finished.
  subroutine report_selection(deck, selection, report)
    type(deck_config_t), intent(in) :: deck
    type(selection_t), intent(in) :: selection
    type(run_report_t), intent(inout) :: report

    call report%add('sampling/greedy/indicator', deck%greedy%indicator)
    call report%add('sampling/greedy/n_points', size(selection%indicators))
    call report%add('sampling/greedy/stopped_by', selection%stopped_by)
    call report%add('sampling/greedy/largest_indicator_left', selection%largest_left)
  end subroutine report_selection

  !> Returns `200 points by projection, tolerance none, max_points 200: ended by max_points; largest indicator left 1.2e-04`; empty
  !> if there is no selection.
  pure function selection_text(selection) result(text)
    type(selection_t), intent(in) :: selection
    character(:), allocatable :: text

    text = ''
    if (.not. allocated(selection%rule)) return
    text = counted(size(selection%indicators), 'point') // ' ' // selection%rule // ': ended by ' // selection%stopped_by // &
      '; largest indicator left ' // csv_number(selection%largest_left)
  end function selection_text

  !> Adds reduction.dirichlet and, below reduction/clusters/1, ... or, with one cluster, below reduction, the kind of model and the
  !> number of contact rows of each cluster; of a hyper-reduced one also its numbers of snapshots, modes, hats and cells, condition
  !> numbers, ranks and warnings, of a condensed one the number of reference sets, of an interpolated one the number of
  !> factorizations, its largest error and the training point that has it, and whether it has a bound. With several clusters also
  !> their number, and loss and silhouette of the clustering. The fallback is left out.
  subroutine report_model(model, report)
    type(model_t), intent(in) :: model
    type(run_report_t), intent(inout) :: report
    integer :: k

    call report%add('reduction/dirichlet', model%dirichlet)
    if (model%n_clusters() == 1) then
      call report_part(model%parts(1)%reduced, 'reduction/', report)
      return
    end if
    call report%add('reduction/n_clusters', model%n_clusters())
    call report%add('reduction/clustering/loss', model%choice%loss)
    call report%add('reduction/clustering/silhouette', model%choice%silhouette)
    do k = 1, model%n_clusters()
      call report_part(model%parts(k)%reduced, 'reduction/clusters/' // to_text(k) // '/', report)
    end do
  end subroutine report_model

  subroutine report_part(part, group, report)
    class(reduced_t), intent(in) :: part
    !> with its last slash
    character(*), intent(in) :: group
    type(run_report_t), intent(inout) :: report

    call report%add(group // 'kind', part%kind())
    select type (part)
    type is (reduced_hhr_t)
      call report_cluster(part%data, group, report)
    type is (condensed_model_t)
      call report%add(group // 'n_contact_rows', part%n_rows())
      call report_compliance(part%compliance, group, report)
    class default
      call report%add(group // 'n_contact_rows', part%n_rows())
    end select
  end subroutine report_part

  subroutine report_compliance(compliance, group, report)
    class(compliance_t), intent(in) :: compliance
    !> with its last slash
    character(*), intent(in) :: group
    type(run_report_t), intent(inout) :: report

    select type (compliance)
    type is (fixed_compliance_t)
      call report%add(group // 'n_reference_sets', size(compliance%pivots%reference_points))
    type is (body_compliance_t)
      call report%add(group // 'n_factorizations', compliance%n_factorizations)
      call report%add(group // 'largest_error', compliance%measured_error)
      call report%add(group // 'worst_training_point', compliance%worst_point)
      ! without one the largest error is an estimate for other points
      call report%add(group // 'has_bound', compliance%has_bound())
    end select
  end subroutine report_compliance

  subroutine report_cluster(cluster, group, report)
    type(hhr_data_t), intent(in) :: cluster
    !> with its last slash
    character(*), intent(in) :: group
    type(run_report_t), intent(inout) :: report

    call report%add(group // 'n_snapshots', size(cluster%training_points))
    call report%add(group // 'n_modes', cluster%n_pod_modes)
    call report%add(group // 'n_extra_modes', cluster%n_extra_modes)
    call report%add(group // 'n_hats', cluster%n_hats)
    call report%add(group // 'hats', hats_text(cluster))
    call report%add(group // 'n_reduced_unknowns', cluster%n_modes)
    call report%add(group // 'n_contact_rows', cluster%n_rows)
    call report%add(group // 'n_cells', size(cluster%cells))
    call report%add(group // 'condition_number', cluster%condition_number)
    call report%add(group // 'rank', cluster%rank)
    call report%add(group // 'basis_rank', cluster%basis_rank)
    call report%add(group // 'stiffness_condition', cluster%stiffness_condition)
    call report%add(group // 'stiffness_rank', cluster%stiffness_rank)
    call report%add(group // 'primal_rank_expected', cluster%primal_rank_expected)
    call report%add(group // 'warnings', cluster%warnings)
  end subroutine report_cluster

  !> Returns one line, without a line end, that describes the model: cluster_text of a hyper-reduced one, else its kind and its
  !> contact rows: `condensed model of 33 contact rows`. With several clusters it gives their number, then each cluster with its
  !> number of snapshots. The fallback is left out.
  pure function model_text(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: k

    text = part_text(model%parts(1)%reduced)
    if (model%n_clusters() == 1) return
    text = counted(model%n_clusters(), 'cluster')
    do k = 1, model%n_clusters()
      text = text // merge(': ', '; ', k == 1) // counted(size(model%parts(k)%reduced%training_points()), &
        'snapshot') // ', ' // part_text(model%parts(k)%reduced)
    end do
  end function model_text

  pure function part_text(part) result(text)
    class(reduced_t), intent(in) :: part
    character(:), allocatable :: text

    select type (part)
    type is (reduced_hhr_t)
      text = cluster_text(part%data)
    class default
      text = part%kind() // ' model of ' // counted(part%n_rows(), 'contact row')
      if (part%n_flow_points() > 0) text = text // ', ' // counted(part%n_modes(), 'inelastic mode')
    end select
  end function part_text

  !> Returns `36 + 9 modes and 18 hats (63 reduced unknowns), 33 contact rows with a condition number of 7.496, hats: ...`: modes of
  !> the POD + extra modes. Extra modes and hats are named only if there are any; hats_text comes last.
  pure function cluster_text(cluster) result(text)
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable :: text

    text = counted(cluster%n_pod_modes, 'mode')
    if (cluster%n_extra_modes > 0) text = to_text(cluster%n_pod_modes) // ' + ' // counted(cluster%n_extra_modes, 'mode')
    if (cluster%n_hats > 0) text = text // ' and ' // counted(cluster%n_hats, 'hat')
    text = text // ' (' // counted(cluster%n_modes, 'reduced unknown') // '), ' // counted(cluster%n_rows, 'contact row') // &
      ' with a condition number of ' // short_number(cluster%condition_number) // ', hats: ' // hats_text(cluster)
  end function cluster_text

  !> Adds, below points/1, points/2, ..., each point, how its full-order solution ended, its iterations, its time [s] and its
  !> residuals. If it converged: also the number of contacts that are closed, and the sum of all contact forces.
  subroutine report_states(deck, laws, points, states, report)
    type(deck_config_t), intent(in) :: deck
    type(contact_laws_t), intent(in) :: laws
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_points)
    type(contact_state_t), intent(in) :: states(:)
    type(run_report_t), intent(inout) :: report
    character(:), allocatable :: key
    integer :: i

    do i = 1, size(states)
      key = 'points/' // to_text(i) // '/'
      call report%add(key // 'point', format_point(deck%state_parameters, points(:, i)))
      call report%add(key // 'status', reason_text(states(i)%reason))
      call report%add(key // 'iterations', states(i)%n_iterations)
      call report%add(key // 'linear_iterations', states(i)%n_linear_iterations)
      if (states(i)%reason == reason_converged) then
        call report%add(key // 'n_active', count(laws%are_closed(states(i)%multipliers)))
        call report%add(key // 'contact_force', sum(states(i)%normal_forces()))
        call report_friction(key, states(i), report)
      end if
      call report_flow(key, states(i), report)
      call report%add(key // 'seconds', states(i)%seconds)
      call report%add(key // 'residuals/equilibrium', states(i)%residuals%equilibrium)
      call report%add(key // 'residuals/penetration', states(i)%residuals%penetration)
      call report%add(key // 'residuals/negative_multiplier', states(i)%residuals%negative_multiplier)
      call report%add(key // 'residuals/complementarity', states(i)%residuals%complementarity)
      call report%add(key // 'residuals/force_balance', states(i)%residuals%force_balance)
    end do
  end subroutine report_states

  !> Adds how many contacts stick and slip, the work of friction since the last time, and how many solutions were found; nothing
  !> without friction.
  subroutine report_friction(key, state, report)
    !> of the point, with a slash at its end
    character(*), intent(in) :: key
    type(contact_state_t), intent(in) :: state
    type(run_report_t), intent(inout) :: report

    if (.not. allocated(state%slips)) return
    associate (is_closed => state%is_active(:size(state%slips)))
      call report%add(key // 'friction/n_sticking', count(is_closed .and. .not. state%slips))
      call report%add(key // 'friction/n_slipping', count(state%slips))
      call report%add(key // 'friction/work', dot_product(state%multipliers, state%slip))
      if (state%n_solutions > 0) then
        call report%add(key // 'friction/n_solutions', state%n_solutions)
      else
        call report%add(key // 'friction/n_solutions', 'not counted')
      end if
    end associate
  end subroutine report_friction

  !> Adds how Newton's method went where materials flow: how often steps were cut in two, the residual behind each iteration of the
  !> last step, the largest equivalent strains, or up to which time there is an answer. Nothing where no material flows.
  subroutine report_flow(key, state, report)
    !> of the point, with a slash at its end
    character(*), intent(in) :: key
    type(contact_state_t), intent(in) :: state
    type(run_report_t), intent(inout) :: report

    if (.not. allocated(state%flow)) return
    call report%add(key // 'flow/n_cuts', state%flow%n_cuts)
    call report%add(key // 'flow/newton_residuals', state%flow%residuals)
    if (state%reason == reason_converged) then
      call report%add(key // 'flow/largest_plastic_strain', maxval(state%flow%plastic(7, :)))
      call report%add(key // 'flow/largest_creep_strain', maxval(state%flow%creep(7, :)))
    else
      call report%add(key // 'flow/reached', state%flow%reached)
    end if
  end subroutine report_flow

  !> Adds the reaction forces at one point, only prescribed components, below points/<i_point>/reactions/1, 2, ... with the name of
  !> each boundary inside: a name may contain characters that a key may not.
  subroutine report_reactions(i_point, reactions, report)
    !> number of the point in the report, 1-based
    integer, intent(in) :: i_point
    !> of each boundary with prescribed displacements
    type(reaction_t), intent(in) :: reactions(:)
    type(run_report_t), intent(inout) :: report
    character(:), allocatable :: key
    integer :: i, i_component

    do i = 1, size(reactions)
      key = 'points/' // to_text(i_point) // '/reactions/' // to_text(i) // '/'
      call report%add(key // 'boundary', reactions(i)%boundary)
      do i_component = 1, 3
        if (.not. reactions(i)%is_prescribed(i_component)) cycle
        call report%add(key // reactions(i)%axes(i_component), reactions(i)%force(i_component))
      end do
    end do
  end subroutine report_reactions

  !> Returns `; largest penetration 0.0 m, force balance 1.054e-16`, the largest values of all these solutions; empty if there are
  !> none.
  pure function accuracy_text(deck, residuals) result(text)
    !> for the unit of length
    type(deck_config_t), intent(in) :: deck
    !> of each solution
    type(residuals_t), intent(in) :: residuals(:)
    character(:), allocatable :: text

    text = ''
    if (size(residuals) > 0) text = '; largest penetration ' // short_number(maxval(residuals%penetration)) // ' ' // &
      deck%units%length // ', force balance ' // short_number(maxval(residuals%force_balance))
  end function accuracy_text

  !> Adds minimum, median, p95 and maximum of the values below the key. NaN values are left out; if there are no others, the
  !> statistics are NaN (so are those of errors if neither model has contact at any point).
  subroutine report_statistics(report, key, values)
    type(run_report_t), intent(inout) :: report
    !> without a slash at its end
    character(*), intent(in) :: key
    real(rk), intent(in) :: values(:)
    type(statistics_t) :: statistics

    statistics = measured_statistics(values)
    call report%add(key // '/min', statistics%minimum)
    call report%add(key // '/median', statistics%median)
    call report%add(key // '/p95', statistics%p95)
    call report%add(key // '/max', statistics%maximum)
  end subroutine report_statistics
end module sig_reporting
