//! Calls of add-on instructions (spec/programs.md §13).

use super::{Base, MAX_ADD_ONS, MAX_BASES, Run, Scan};
use crate::code::{AddOnCall, Referenced};

impl<'s> Scan<'s> {
    pub(crate) fn add_on(&mut self, call: &'s AddOnCall, power: bool) -> Run<bool> {
        let code = self.code;
        let Some(definition) = code.add_ons.get(call.definition as usize) else {
            return Ok(power);
        };
        let instance = self.address(&call.instance)?;
        let frame = self.s.bases.len();
        if self.s.add_ons >= MAX_ADD_ONS || frame + 1 + call.references.len() > MAX_BASES {
            return Err(self.fault(4, 84, None));
        }
        // Operands of the caller are evaluated with the caller's bases.
        self.s.bases.push(Base::instance(instance));
        for reference in &call.references {
            match self.reference(reference) {
                Ok(base) => self.s.bases.push(base),
                Err(exit) => {
                    self.s.bases.truncate(frame);
                    return Err(exit);
                }
            }
        }
        let outer = self.s.frame;
        let ran = self.add_on_body(call, definition, power, frame);
        self.s.frame = outer;
        self.s.bases.truncate(frame);
        ran
    }

    /// The operand of a parameter by reference.
    fn reference(&mut self, reference: &Referenced) -> Run<Base> {
        let base = reference.place.base;
        let at = self.address(&reference.place)?;
        let (at, mask) = match &reference.bit {
            Some(select) => self.bit_behind(at, base, select)?,
            None => (at, 1),
        };
        let sizes = reference.sizes.unwrap_or_else(|| self.sizes(base));
        Ok(Base { at, mask, sizes })
    }

    fn add_on_body(
        &mut self,
        call: &'s AddOnCall,
        definition: &'s crate::code::AddOn,
        power: bool,
        frame: usize,
    ) -> Run<bool> {
        let (outer, prescan) = (self.s.frame, self.s.prescan);
        let instance = self.s.bases.get(frame).map_or(0, |base| base.at);
        for copy in &call.inputs {
            let value = self.argument(&copy.from)?;
            self.s.frame = frame;
            let assigned = self.assign(&copy.to, value);
            self.s.frame = outer;
            assigned?;
        }
        let (enable_in, in_mask) = definition.enable_in;
        let (enable_out, out_mask) = definition.enable_out;
        self.set(instance + enable_in, in_mask, power);
        self.set(instance + enable_out, out_mask, power);
        self.s.frame = frame;
        self.s.add_ons += 1;
        let zone = std::mem::take(&mut self.s.zone);
        let ran = if prescan {
            self.prescan_add_on(definition)
        } else if power {
            definition.logic.map_or(Ok(()), |routine| self.routine(routine))
        } else {
            definition
                .enable_in_false
                .map_or(Ok(()), |routine| self.routine(routine))
        };
        self.s.add_ons -= 1;
        self.s.zone = zone;
        self.s.frame = outer;
        ran?;
        if prescan {
            return Ok(false);
        }
        if !power {
            self.set(instance + enable_out, out_mask, false);
            return Ok(false);
        }
        for copy in &call.outputs {
            self.s.frame = frame;
            let value = self.argument(&copy.from);
            self.s.frame = outer;
            let value = value?;
            self.assign(&copy.to, value)?;
        }
        Ok(self.has(instance + enable_out, out_mask))
    }

    /// Logic in prescan, then the routine Prescan as in a scan.
    fn prescan_add_on(&mut self, definition: &crate::code::AddOn) -> Run<()> {
        if let Some(logic) = definition.logic {
            self.prescan(logic)?;
        }
        if let Some(routine) = definition.prescan {
            self.s.prescan = false;
            let ran = self.routine(routine);
            self.s.prescan = true;
            ran?;
        }
        Ok(())
    }
}
