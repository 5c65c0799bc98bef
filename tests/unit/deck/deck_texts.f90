! SPDX-License-Identifier: BSD-3-Clause
!> Decks for the tests, and assertions about what reading them gives.
module deck_texts
  use funit, only: assertEqual, assertTrue
  use sig_deck_config, only: deck_config_t
  use sig_deck_read, only: read_deck
  use sig_errors, only: error_list_t, error_report
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: small_deck, two_parameter_deck, replaced, assert_accepted, assert_refused

  character(*), parameter :: eol = new_line('a')

contains

  !> The smallest deck with a boundary condition, a contact and an output point; each on a line of its own.
  pure function small_deck() result(text)
    character(:), allocatable :: text

    text = 'mesh: {file: a.msh, model: plane_strain}' // eol // &
      'parameters: {push: {min: 0.25, max: 0.75}}' // eol // &
      'materials: {block: {regions: [lower, upper], young_modulus: 15.0, poisson_ratio: 0.35}}' // eol // &
      'boundary_conditions: [{boundary: base, displacement: {x: 0.0, y: push}}]' // eol // &
      'contact: [{first: lower_arc, second: upper_arc, direction: [0, 1]}]' // eol // &
      'output: {points: [{push: 0.3}]}' // eol
  end function small_deck

  !> The same with a second parameter.
  function two_parameter_deck() result(text)
    character(:), allocatable :: text

    text = replaced('0.75}}', '0.75}, slide: {min: -1, max: 1, unit: mm}}')
    text = replaced('push: 0.3', 'slide: 0.5, push: 0.3', deck=text)
  end function two_parameter_deck

  !> A deck (the small one unless another is given) with one piece replaced; a piece that is not there is a slip of the test.
  function replaced(old, new, deck) result(text)
    character(*), intent(in) :: old
    character(*), intent(in) :: new
    character(*), intent(in), optional :: deck
    character(:), allocatable :: text
    integer :: i_start

    text = small_deck()
    if (present(deck)) text = deck
    i_start = index(text, old)
    call assertTrue(i_start > 0, message='the deck does not contain ' // old)
    text = text(:i_start - 1) // new // text(i_start + len(old):)
  end function replaced

  !> Reading gives no error.
  subroutine assert_accepted(text, config)
    character(*), intent(in) :: text
    type(deck_config_t), intent(out) :: config
    type(error_list_t) :: errors

    call read_deck('decks/small.yaml', text, config, errors)
    if (errors%n_errors() == 0) return
    call assertTrue(.false., message=error_report(errors%errors(1)))
  end subroutine assert_accepted

  !> Reading gives one error, `line:column: message`, and (where given) a hint that contains a text.
  subroutine assert_refused(text, expected, hint)
    character(*), intent(in) :: text
    character(*), intent(in) :: expected
    character(*), intent(in), optional :: hint
    type(deck_config_t) :: config
    type(error_list_t) :: errors

    call read_deck('small.yaml', text, config, errors)
    call assertEqual(1, errors%n_errors(), message='number of errors; expected: ' // expected)
    if (errors%n_errors() == 0) return
    associate (error => errors%errors(1))
      call assertEqual('small.yaml', error%file)
      call assertEqual(expected, to_text(error%line) // ':' // to_text(error%column) // ': ' // error%message)
      if (present(hint)) call assertTrue(index(error%hint, hint) > 0, message='hint "' // error%hint // '" lacks "' // hint // '"')
    end associate
  end subroutine assert_refused
end module deck_texts
