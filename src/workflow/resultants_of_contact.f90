! SPDX-License-Identifier: BSD-3-Clause
!> Area, resultant force and moment of each contact of the deck, with friction also the share that slips and the work of friction:
!> the map that computes them, and their values in the report.
module sig_resultants_of_contact
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_summary, only: contact_name
  use sig_deck_units, only: area_unit, moment_unit
  use sig_kinds, only: rk
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged
  use sig_resultant_map, only: resultant_map_t
  use sig_run_report, only: run_report_t
  use sig_text, only: append_text, to_text
  implicit none(type, external)
  private
  public :: create_resultant_map, report_resultants

contains

  !> Creates the map from the contact forces of all rows to the resultants of each contact entry of the deck. They act on the first
  !> surface that the entry names, also where the rows belong to the second one. Local.
  subroutine create_resultant_map(problem, map)
    type(problem_t), intent(in) :: problem
    type(resultant_map_t), intent(out) :: map
    integer :: i

    allocate (map%names(0))
    do i = 1, size(problem%deck%contact)
      call append_text(map%names, contact_name(problem%deck, i))
    end do
    map%entries = problem%force_rows%contact_entry
    call problem%force_rows%unit_resultants(problem%mesh%coordinates, map%unit_forces, map%unit_moments)
    map%unit_imbalances = problem%force_rows%unit_imbalances(problem%mesh%coordinates)
    call return_to_first(problem%is_swapped, map)
    call map%complete(problem%mesh%n_dim)
  end subroutine create_resultant_map

  !> Changes resultants of the second surface to those of the first one, for contacts whose rows belong to the second surface.
  pure subroutine return_to_first(is_swapped, map)
    !> the rows belong to the second surface, shape (n_entries)
    logical, intent(in) :: is_swapped(:)
    type(resultant_map_t), intent(inout) :: map
    integer :: k

    do k = 1, size(map%entries)
      if (.not. is_swapped(map%entries(k))) cycle
      map%unit_forces(:, k) = -map%unit_forces(:, k)
      map%unit_moments(:, k) = map%unit_imbalances(:, k) - map%unit_moments(:, k)
    end do
  end subroutine return_to_first

  !> Adds area, force, moment and moment imbalance of each contact at all points to the report, and the units of areas and moments;
  !> with friction also the share of the area that slips, and the dissipation: the work of friction since the last time. Force and
  !> moment sum normal forces and friction. The numbers are NaN where a point has no solution, and always 0 for a contact without
  !> rows. Local.
  subroutine report_resultants(problem, states, report)
    type(problem_t), intent(in) :: problem
    !> full-order solutions, shape (n_points)
    type(contact_state_t), intent(in) :: states(:)
    type(run_report_t), intent(inout) :: report
    type(resultant_map_t) :: map
    real(rk) :: multipliers(problem%force_rows%n_rows)
    character(:), allocatable :: group
    integer :: i

    call report%add('units/contact_area', area_unit(problem%deck))
    call report%add('units/moment', moment_unit(problem%deck))
    call create_resultant_map(problem, map)
    do i = 1, size(states)
      multipliers = ieee_value(1.0_rk, ieee_quiet_nan)
      if (states(i)%reason == reason_converged) multipliers = states(i)%multipliers
      group = 'points/' // to_text(i) // '/contacts/'
      call report_point(map, problem%laws, problem%force_rows%areas, multipliers, group, report)
      if (problem%laws%remembers()) call report_slip(map, problem%laws, problem%force_rows%areas, multipliers, states(i), group, &
        report)
    end do
  end subroutine report_resultants

  !> Adds the resultants of one point, below <group>1, <group>2, ... for the contacts of the deck, with the names of the surfaces
  !> inside: names may contain characters that a key may not. NaN multipliers give NaN.
  subroutine report_point(map, laws, row_areas, multipliers, group, report)
    type(resultant_map_t), intent(in) :: map
    type(contact_laws_t), intent(in) :: laws
    !> shape (n_rows)
    real(rk), intent(in) :: row_areas(:)
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> path of the keys, with its last slash
    character(*), intent(in) :: group
    type(run_report_t), intent(inout) :: report
    real(rk) :: areas(map%n_entries()), forces(size(map%unit_forces, 1), map%n_entries())
    real(rk) :: moments(map%n_moments(), map%n_entries()), imbalances(map%n_moments(), map%n_entries())
    integer :: i

    call map%evaluate(laws, row_areas, multipliers, areas, forces, moments)
    imbalances = map%imbalances(multipliers)
    do i = 1, map%n_entries()
      call report%add(group // to_text(i) // '/surfaces', map%names(i)%text)
      call report%add(group // to_text(i) // '/area', areas(i))
      call report%add(group // to_text(i) // '/force', forces(:, i))
      call report%add(group // to_text(i) // '/moment', moments(:, i))
      call report%add(group // to_text(i) // '/moment_imbalance', imbalances(:, i))
    end do
  end subroutine report_point

  !> Adds slip_share and dissipation of each contact of the deck with friction at one point, beside its resultants.
  subroutine report_slip(map, laws, row_areas, multipliers, state, group, report)
    type(resultant_map_t), intent(in) :: map
    type(contact_laws_t), intent(in) :: laws
    !> as in report_point
    real(rk), intent(in) :: row_areas(:)
    real(rk), intent(in) :: multipliers(:)
    type(contact_state_t), intent(in) :: state
    character(*), intent(in) :: group
    type(run_report_t), intent(inout) :: report
    real(rk) :: shares(map%n_entries()), dissipations(map%n_entries())
    integer :: i

    shares = ieee_value(shares, ieee_quiet_nan)
    dissipations = shares
    if (state%reason == reason_converged) then
      shares = map%slip_shares(laws, row_areas, multipliers, state%slips)
      dissipations = map%dissipations(multipliers, state%slip)
    end if
    do i = 1, map%n_entries()
      if (.not. map%has_friction(laws, i)) cycle
      call report%add(group // to_text(i) // '/slip_share', shares(i))
      call report%add(group // to_text(i) // '/dissipation', dissipations(i))
    end do
  end subroutine report_slip
end module sig_resultants_of_contact
