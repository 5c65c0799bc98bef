! SPDX-License-Identifier: BSD-3-Clause
!> The result of each round of a refinement, as a line of the log and as a row of refinement.csv.
module sig_refinement_rounds
  use sig_candidate_pool, only: pool_errors_t
  use sig_errors, only: error_t
  use sig_file_system, only: write_text_file
  use sig_kinds, only: rk
  use sig_run_report, only: run_report_t
  use sig_statistics, only: statistics_t, summarize
  use sig_text, only: counted, csv_number, to_text
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: refinement_round_t, make_round, report_refinement, round_text, three_digits, &
    n_failed, statistic_of, worst_cluster, write_refinement_table

  !> [-] share_above counts the errors above this
  real(rk), parameter :: large_error = 0.1_rk

  !> What one round did, and the errors of its model.
  type :: refinement_round_t
    !> what the round did: start, number (another number of clusters), add (snapshots) or split (a cluster)
    character(:), allocatable :: action
    !> cluster that was changed; 0 = all
    integer :: cluster = 0
    integer :: n_clusters = 0
    integer :: n_snapshots = 0
    !> cluster with the largest error at the candidates that may become snapshots
    integer :: worst_cluster = 0
    !> [-] at the candidates that are kept for measuring
    type(statistics_t) :: errors
    !> number of these candidates whose error is infinite
    integer :: n_failed = 0
    !> [-] share of these candidates with an error above 0.1, from 0 to 1
    real(rk) :: share_above = 0
  end type refinement_round_t

contains

  !> Returns a round with these values and the statistics of its errors; see refinement_round_t.
  pure function make_round(action, cluster, n_clusters, n_snapshots, worst, errors) result(round)
    !> these four as in refinement_round_t
    character(*), intent(in) :: action
    integer, intent(in) :: cluster
    integer, intent(in) :: n_clusters
    integer, intent(in) :: n_snapshots
    !> cluster with the largest error
    integer, intent(in) :: worst
    !> [-] at the candidates that are kept for measuring
    real(rk), intent(in) :: errors(:)
    type(refinement_round_t) :: round

    round%action = action
    round%cluster = cluster
    round%n_clusters = n_clusters
    round%n_snapshots = n_snapshots
    round%worst_cluster = worst
    round%errors = summarize(errors)
    round%n_failed = n_failed(errors)
    round%share_above = real(count(errors > large_error), rk) / max(1, round%errors%n_values)
  end function make_round

  !> Returns the cluster with the largest statistic of the errors at its candidates (0 without an error that is a number), the first
  !> of those that are equal to 1e-8 relative; 0 if none may be chosen.
  pure integer function worst_cluster(statistic, errors, n_clusters, may_choose) result(worst)
    !> median, p95 or max
    character(*), intent(in) :: statistic
    type(pool_errors_t), intent(in) :: errors
    integer, intent(in) :: n_clusters
    !> shape (n_clusters)
    logical, intent(in) :: may_choose(:)
    real(rk) :: largest, value
    integer :: k

    worst = 0
    largest = -1
    do k = 1, n_clusters
      if (.not. may_choose(k)) cycle
      value = statistic_of(statistic, pack(errors%values, errors%cluster == k))
      if (value <= largest * (1 + tie_tolerance)) cycle
      worst = k
      largest = value
    end do
  end function worst_cluster

  !> Returns a statistic of the values. Values that are not a number are left out; the result is 0 if there are no others.
  pure real(rk) function statistic_of(name, values) result(value)
    !> median, p95 or max
    character(*), intent(in) :: name
    real(rk), intent(in) :: values(:)
    type(statistics_t) :: statistics

    statistics = summarize(values)
    select case (name)
    case ('median')
      value = statistics%median
    case ('max')
      value = statistics%maximum
    case default
      value = statistics%p95
    end select
  end function statistic_of

  !> Returns the number of infinite errors: the cluster has no answer, or its error cannot be measured.
  pure integer function n_failed(values)
    !> [-] errors
    real(rk), intent(in) :: values(:)

    n_failed = count(values > huge(values))
  end function n_failed

  !> Returns the line of the log: `round 2: cluster 1 gets 5 snapshots: 3 clusters, 36 snapshots; e_lambda_rid at 95 candidates:
  !> median 1.20E-02, p95 3.40E-01, 12 % above 0.1`, and at its end the number of infinite errors if there are any (`, 2 failed`).
  !> Candidates without an error (NaN) do not count.
  pure function round_text(i_round, round, n_new, measure) result(text)
    !> from 0
    integer, intent(in) :: i_round
    type(refinement_round_t), intent(in) :: round
    !> snapshots that joined in this round; used only if its action is add
    integer, intent(in) :: n_new
    !> name of the error
    character(*), intent(in) :: measure
    character(:), allocatable :: text

    text = 'round ' // to_text(i_round) // ': '
    if (round%action == 'add') text = text // 'cluster ' // to_text(round%cluster) // ' gets ' // counted(n_new, 'snapshot') // ': '
    if (round%action == 'split') text = text // 'cluster ' // to_text(round%cluster) // ' is split: '
    text = text // counted(round%n_clusters, 'cluster') // ', ' // counted(round%n_snapshots, 'snapshot') // '; ' // measure // &
      ' at ' // counted(round%errors%n_values, 'candidate') // ': median ' // three_digits(round%errors%median) // ', p95 ' // &
      three_digits(round%errors%p95) // ', ' // to_text(nint(100 * round%share_above)) // ' % above 0.1'
    if (round%n_failed > 0) text = text // ', ' // to_text(round%n_failed) // ' failed'
  end function round_text

  !> Returns a number with three significant digits, such as `1.20E-02`, or `infinite` for plus infinity.
  pure function three_digits(value) result(text)
    real(rk), intent(in) :: value
    character(:), allocatable :: text
    character(16) :: buffer

    write (buffer, '(es9.2)') value
    if (value > huge(value)) buffer = 'infinite'
    text = trim(adjustl(buffer))
  end function three_digits

  !> Adds to the report, below reduction/refinement, how a refinement ended, with the number of rounds after round 0, the number of
  !> candidates that measured in the last round, and the number of infinite errors of the best one. Requires: there is a round.
  subroutine report_refinement(rounds, best_round, is_reached, ending, report)
    type(refinement_round_t), intent(in) :: rounds(:)
    !> number of the round that gave the model, from 0 on
    integer, intent(in) :: best_round
    !> the target was reached
    logical, intent(in) :: is_reached
    !> sentence that says how it ended
    character(*), intent(in) :: ending
    type(run_report_t), intent(inout) :: report

    call report%add('reduction/refinement/n_rounds', size(rounds) - 1)
    call report%add('reduction/refinement/best_round', best_round)
    call report%add('reduction/refinement/n_candidates', rounds(size(rounds))%errors%n_values)
    call report%add('reduction/refinement/n_failed', rounds(best_round + 1)%n_failed)
    call report%add('reduction/refinement/target_reached', trim(merge('yes', 'no ', is_reached)))
    call report%add('reduction/refinement/ending', ending)
  end subroutine report_refinement

  !> Writes refinement.csv to the path: a head, then one line per round, from round 0 on. Errors: the file cannot be written.
  subroutine write_refinement_table(rounds, path, error)
    type(refinement_round_t), intent(in) :: rounds(:)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: text
    integer :: i

    text = 'round,action,cluster,n_clusters,n_snapshots,n_candidates,n_failed,worst_cluster,median,p95,max,share_above_0.1' // &
      new_line('a')
    do i = 1, size(rounds)
      associate (round => rounds(i))
        text = text // to_text(i - 1) // ',' // round%action // ',' // to_text(round%cluster) // ',' // &
          to_text(round%n_clusters) // ',' // to_text(round%n_snapshots) // ',' // to_text(round%errors%n_values) // ',' // &
          to_text(round%n_failed) // ',' // to_text(round%worst_cluster) // ',' // csv_number(round%errors%median) // ',' // &
          csv_number(round%errors%p95) // ',' // csv_number(round%errors%maximum) // ',' // csv_number(round%share_above) // &
          new_line('a')
      end associate
    end do
    call write_text_file(path, text, error)
  end subroutine write_refinement_table
end module sig_refinement_rounds
