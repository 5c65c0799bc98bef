! SPDX-License-Identifier: BSD-3-Clause
!> The errors of the fields that users read off a part: von Mises stresses and contact pressures of an answer, compared with those
!> of the full-order solution at the same point. Both get them from the same field map, so only displacements and contact forces
!> make the difference.
module sig_field_errors
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use sig_answer_errors, only: comparison_t
  use sig_contact_rows, only: contact_rows_t
  use sig_field_map, only: field_map_t, field_values_t
  use sig_kinds, only: rk
  use sig_nodal_values, only: nodal_pressures
  implicit none(type, external)
  private
  public :: compare_von_mises, compare_pressures

contains

  !> Compares the von Mises stresses s_r of an answer with the full-order ones s. The size of both comparisons is max s. The
  !> difference of `largest` is |max s_r - max s|, that of `everywhere` max |s_r - s|. Stresses are compared as means over the cells
  !> and smoothed at the nodes; each comparison is that of the two whose relative error is larger. The differences are NaN if some
  !> dof has no displacement.
  pure subroutine compare_von_mises(map, theta, reduced, displacement, answered, exact, largest, everywhere)
    type(field_map_t), intent(in) :: map
    !> values of map%terms at the point
    real(rk), intent(in) :: theta(:)
    !> [length] displacement of the answer and of the full-order model, shape (n_dofs)
    real(rk), intent(in) :: reduced(:)
    real(rk), intent(in) :: displacement(:)
    !> of both: plastic strains and creep strains, where materials flow
    type(field_values_t), intent(inout) :: answered
    type(field_values_t), intent(inout) :: exact
    !> [force/length**2]
    type(comparison_t), intent(out) :: largest
    type(comparison_t), intent(out) :: everywhere

    call exact%take_displacement(map, displacement)
    call exact%take_stresses(map, theta)
    if (any(ieee_is_nan(reduced))) then
      largest = comparison_t(ieee_value(1.0_rk, ieee_quiet_nan), maxval(exact%von_mises))
      everywhere = largest
      return
    end if
    call answered%take_displacement(map, reduced)
    call answered%take_stresses(map, theta)
    largest = worse_of(compare_largest(answered%von_mises, exact%von_mises), &
      compare_largest(answered%von_mises_smoothed, exact%von_mises_smoothed))
    everywhere = worse_of(compare_everywhere(answered%von_mises, exact%von_mises), &
      compare_everywhere(answered%von_mises_smoothed, exact%von_mises_smoothed))
  end subroutine compare_von_mises

  !> [force/length**2] Compares the contact pressures p_r of an answer with the full-order ones p at all nodes: max |p_r - p| and
  !> max p.
  pure type(comparison_t) function compare_pressures(rows, n_nodes, reduced, multipliers) result(comparison)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_nodes
    !> [force] contact forces of the answer and of the full-order model, shape (n_multipliers)
    real(rk), intent(in) :: reduced(:)
    real(rk), intent(in) :: multipliers(:)

    comparison = compare_everywhere(nodal_pressures(rows, reduced, n_nodes), nodal_pressures(rows, multipliers, n_nodes))
  end function compare_pressures

  !> Returns |max a - max b| and max b.
  pure type(comparison_t) function compare_largest(answered, exact) result(comparison)
    !> same shape, values at least 0
    real(rk), intent(in) :: answered(:)
    real(rk), intent(in) :: exact(:)

    comparison = comparison_t(abs(maxval(answered) - maxval(exact)), maxval(exact))
  end function compare_largest

  !> Returns max |a - b| and max b.
  pure type(comparison_t) function compare_everywhere(answered, exact) result(comparison)
    !> same shape, values at least 0
    real(rk), intent(in) :: answered(:)
    real(rk), intent(in) :: exact(:)

    comparison = comparison_t(maxval(abs(answered - exact)), maxval(exact))
  end function compare_everywhere

  !> Returns the comparison whose difference is larger in relation to its size; the other one if the size of one is 0.
  pure type(comparison_t) function worse_of(first, second) result(worse)
    type(comparison_t), intent(in) :: first
    type(comparison_t), intent(in) :: second

    worse = first
    if (first%size <= 0 .or. second%difference * first%size > first%difference * second%size) worse = second
    if (second%size <= 0) worse = first
  end function worse_of
end module sig_field_errors
