! SPDX-License-Identifier: BSD-3-Clause
!> The part of the text of `signorom describe` about a hyper-reduced model.
module sig_hhr_description
  use sig_description_line, only: line
  use sig_hhr_data, only: hhr_data_t
  use sig_text, only: counted, short_number, to_text
  implicit none(type, external)
  private
  public :: describe_hhr, hats_text

contains

  !> Returns lines about a hyper-reduced model, each with its line end. Requires: complete_cluster or read_cluster.
  pure function describe_hhr(cluster) result(text)
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable :: text
    integer :: i

    text = line('  modes', to_text(cluster%n_modes)) // &
      line('  integration domain', counted(size(cluster%cells), 'cell') // ', ' // counted(cluster%n_rows, 'contact row')) // &
      line('  hat functions', hats_text(cluster)) // &
      line('  kappa', condition_text(cluster)) // &
      line('  cond(K_r)', short_number(cluster%stiffness_condition)) // &
      line('  forces elsewhere', fit_text(cluster))
    if (cluster%certificate%is_there()) text = text // line('  certificate', 'by a lift and ' // &
      counted(size(cluster%certificate%pattern_forces, 2), 'force pattern'))
    do i = 1, size(cluster%warnings)
      if (len(cluster%warnings(i)%text) > 0) text = text // line('  warning', cluster%warnings(i)%text)
    end do
  end function describe_hhr

  !> Returns a text without line end: the number of hats. If the training recorded its steps (history), the rank of (11) and kappa
  !> without hats follow, which show whether the model needs hats.
  pure function hats_text(cluster) result(text)
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable :: text

    text = to_text(cluster%n_hats)
    if (size(cluster%history%ranks) == 0) return
    text = text // '; without them the rank of (11) is ' // to_text(cluster%history%ranks(1)) // ' of ' // to_text(cluster%n_rows)
    if (cluster%history%ranks(1) == cluster%n_rows) text = text // ', and its condition number is ' // &
      short_number(cluster%history%condition_numbers(1))
  end function hats_text

  pure function fit_text(cluster) result(text)
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable :: text

    text = 'fitted to forces and displacements'
    if (.not. cluster%fits_displacements) text = 'fitted to forces'
  end function fit_text

  pure function condition_text(cluster) result(text)
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable :: text

    text = short_number(cluster%condition_number)
    if (cluster%rank < cluster%n_rows) text = 'infinite (rank ' // to_text(cluster%rank) // ' of ' // to_text(cluster%n_rows) // &
      ': contact forces of the domain may not be unique)'
  end function condition_text
end module sig_hhr_description
