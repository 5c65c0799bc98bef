! SPDX-License-Identifier: BSD-3-Clause
!> Rules of a greedy selection: which candidates a round takes, and when the selection ends.
module sig_greedy_rules
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_deck_config, only: deck_config_t, greedy_config_t
  use sig_farthest_points, only: farthest_points
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_parameter_space, only: format_point
  use sig_rounding, only: rounding
  use sig_selection, only: selection_t, stopped_by_budget, stopped_by_candidates, stopped_by_tolerance
  use sig_text, only: csv_number, to_text
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: begin_far_apart, box_of, cut_at_end, log_choice, measured_ratio, pick_worst, selection_end

  !> [-] an indicator up to this is rounding: the chosen points represent the candidate
  real(rk), parameter :: negligible = 1.0e-13_rk

contains

  !> Returns minimum (row 1) and maximum (row 2) of each parameter, shape (2, n_parameters).
  pure function box_of(deck) result(box)
    type(deck_config_t), intent(in) :: deck
    real(rk), allocatable :: box(:, :)

    box = transpose(reshape([deck%parameters%minimum, deck%parameters%maximum], [size(deck%parameters), 2]))
  end function box_of

  !> Appends greedy.initial candidates that are far from each other (farthest_points) to the selection, with NaN as indicators.
  !> Requires: there are at least as many candidates.
  subroutine begin_far_apart(deck, candidates, selection)
    type(deck_config_t), intent(in) :: deck
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(selection_t), intent(inout) :: selection
    real(rk) :: none(deck%greedy%n_initial)

    none = ieee_value(none, ieee_quiet_nan)
    call selection%append(candidates(:, farthest_points(candidates, box_of(deck), size(none))), none)
  end subroutine begin_far_apart

  !> Shortens a selection to what the deck's max_points and tolerance allow; the run that made it may have had others. The first
  !> point after the initial ones whose indicator is at most the tolerance is left out with all later ones. Afterwards the
  !> selection counts as not finished, also if nothing was left out.
  subroutine cut_at_end(deck, selection)
    type(deck_config_t), intent(in) :: deck
    type(selection_t), intent(inout) :: selection
    integer :: i, n

    n = min(size(selection%indicators), deck%greedy%max_points)
    do i = deck%greedy%n_initial + 1, n
      if (selection%indicators(i) > deck%greedy%tolerance) cycle
      n = i - 1
      exit
    end do
    call selection%shorten(n)
  end subroutine cut_at_end

  !> Appends the candidates with the largest defects to the selection, at most limits%batch and as long as selection_end allows; if
  !> none, sets selection%stopped_by. Sets selection%largest_left to the largest defect of the candidates that were not chosen
  !> before this round, 0 if there are none. Neighbors have large defects together, so the points of one round keep a distance:
  !> half_spacing for the number of points after a full round. Logs each choice. Local.
  subroutine pick_worst(deck, limits, candidates, defects, selection, chosen)
    type(deck_config_t), intent(in) :: deck
    !> where the selection ends, and how many points a round has
    type(greedy_config_t), intent(in) :: limits
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    !> [-] shape (n_candidates); afterwards -1 where a candidate is chosen, now or before, or too near to one of this round
    real(rk), intent(inout) :: defects(:)
    type(selection_t), intent(inout) :: selection
    !> numbers of the candidates of this round, 1-based
    integer, allocatable, intent(out) :: chosen(:)
    real(rk) :: box(2, size(candidates, 1)), largest
    integer :: i, n

    box = box_of(deck)
    allocate (chosen(0))
    n = size(selection%indicators)
    do i = 1, n
      call leave_out(candidates, box, selection%points(:, i), 0.0_rk, defects)
    end do
    selection%largest_left = max(0.0_rk, maxval(defects))
    do while (size(chosen) < limits%batch)
      largest = maxval(defects)
      if (selection_end(limits, n + size(chosen), largest) /= '') exit
      i = first_largest(defects)
      call selection%append(candidates(:, i:i), defects(i:i))
      chosen = [chosen, i]
      call log_choice(deck, n + size(chosen), trim(merge('estimate', 'defect  ', limits%indicator == 'audit')), defects(i), &
        candidates(:, i))
      call leave_out(candidates, box, candidates(:, i), half_spacing(n + limits%batch, size(box, 2)), defects)
    end do
    if (size(chosen) == 0) selection%stopped_by = selection_end(limits, n, largest)
  end subroutine pick_worst

  !> [-] Returns the largest ratio of the errors that were measured at chosen points to the indicators that chose them; 0 if there
  !> is none.
  pure real(rk) function measured_ratio(selection) result(ratio)
    type(selection_t), intent(in) :: selection
    integer :: i

    ratio = 0
    do i = 1, size(selection%indicators)
      associate (errors => selection%errors(:, i), indicator => selection%indicators(i))
        if (indicator > 0 .and. indicator <= huge(ratio) .and. all(errors >= 0)) ratio = max(ratio, maxval(errors) / indicator)
      end associate
    end do
  end function measured_ratio

  !> [-] Returns half the distance between neighbors if n_points points fill evenly a box whose sides have length 1.
  pure real(rk) function half_spacing(n_points, n_parameters)
    integer, intent(in) :: n_points
    integer, intent(in) :: n_parameters

    half_spacing = real(n_points, rk)**(-1.0_rk / n_parameters) / 2
  end function half_spacing

  !> Sets the defect to -1 for candidates whose Euclidean distance from the point `place`, after the box was scaled to sides of
  !> length 1, is less than `distance` or less than 1e-12. The defects of the others stay.
  pure subroutine leave_out(candidates, box, place, distance, defects)
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    !> of box_of
    real(rk), intent(in) :: box(:, :)
    !> shape (n_parameters)
    real(rk), intent(in) :: place(:)
    !> [-] in the scaled box
    real(rk), intent(in) :: distance
    !> [-] shape (n_candidates)
    real(rk), intent(inout) :: defects(:)
    integer :: i

    do i = 1, size(defects)
      if (norm2((candidates(:, i) - place) / (box(2, :) - box(1, :))) < max(distance, rounding)) defects(i) = -1
    end do
  end subroutine leave_out

  !> Returns why no further point is chosen, the first of these that holds: `candidates` (none is left), `tolerance` (`largest` is
  !> at most the tolerance, if there is one), `candidates` (`largest` is at most 1e-13, that is, rounding), `max_points`
  !> (n_chosen has reached them); empty if a point may be chosen.
  pure function selection_end(limits, n_chosen, largest) result(reason)
    type(greedy_config_t), intent(in) :: limits
    !> number of points so far
    integer, intent(in) :: n_chosen
    !> [-] largest indicator of the candidates that are left; negative if none is left
    real(rk), intent(in) :: largest
    character(:), allocatable :: reason

    reason = ''
    if (largest < 0) then
      reason = stopped_by_candidates
    else if (largest <= limits%tolerance .and. limits%tolerance > 0) then
      reason = stopped_by_tolerance
    else if (largest <= negligible) then
      reason = stopped_by_candidates
    else if (n_chosen >= limits%max_points) then
      reason = stopped_by_budget
    end if
  end function selection_end

  !> Logs a choice: `greedy point 6: projection error 1.234567E-02 at P1 = 5.0 MPa, h1 = 0.6 mm`.
  subroutine log_choice(deck, i_point, what, indicator, point)
    type(deck_config_t), intent(in) :: deck
    !> position in the selection, 1-based
    integer, intent(in) :: i_point
    !> name of the indicator: defect, estimate or projection error
    character(*), intent(in) :: what
    !> [-] its value at the point
    real(rk), intent(in) :: indicator
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)

    call log_info('greedy point ' // to_text(i_point) // ': ' // what // ' ' // csv_number(indicator) // ' at ' // &
      format_point(deck%parameters, point))
  end subroutine log_choice
end module sig_greedy_rules
